"""Release check: wheel and sdist are built, checked, and used in clean environments.

It needs nothing but Python with ``venv``; its environments lie in ``.venv-release``.

    make release-check                                      # everything (minutes)
    make release-check ARGS="extras"                        # one of the checks
    make release-check ARGS="readme --python python3.12"    # with another interpreter
    make release-check ARGS="extras --without train"        # saves gigabytes of torch
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
HOME, DIST = ROOT / ".venv-release", ROOT / "dist"
BIN, CLEAN = HOME / "tools" / "bin", HOME / "clean"
TOOLS = ("build", "twine", "check-wheel-contents", "validate-pyproject[all]", "uv")
# Old packages warn of each other.
TESTS = ("-m", "pytest", "-q", "-m", "not slow and not long", "-W", "ignore::DeprecationWarning")

TRAIN = """
from hazbot_gym import load_training, train
options = {"n_steps": 16}
train(load_training(algorithm="ppo", steps=256, worlds=4, options=options), out="trained")
"""
FUZZY = """
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert
from hazbot_gym.policies.fuzzy_system import control_system
control_system(FuzzyExpert(), points=61)
"""
WALLS = """
from pathlib import Path
from hazbot_gym.task.wall_files import read_walls
Path("walls.wkt").write_text("LINESTRING (0 1, 9 1)")
read_walls(Path("walls.wkt"))
"""
ROBOTS = """
from pettingzoo.test import parallel_api_test
from hazbot_gym.envs.robots import parallel_env
parallel_api_test(parallel_env(2), num_cycles=10)
"""
LIVE = """
from hazbot_gym.live import server
from hazbot_gym.live.policies import Policies
server.Live(Policies(), 8765).application()
"""
# What each extra is for, used in an environment that has nothing but this extra.
USES: dict[str, tuple[tuple[str, ...], ...]] = {
    "": (("hazbot", "list"), ("hazbot", "eval", "--policy", "ppo", "--episodes", "2")),
    "train": (("python", "-c", TRAIN),),
    "fuzzy": (("python", "-c", FUZZY),),
    "render": (("hazbot", "watch", "--policy", "idm", "--save", "frame.png"),),
    "tracks": (("python", "-c", "import hazbot_gym.task.track_files, h5py, shapely"),),
    "places": (("python", "-c", WALLS),),
    "study": (("hazbot", "study", "--episodes", "2", "--out", "study"),),
    "export": (("hazbot", "export", "--policy", "ppo", "--format", "onnx", "--out", "there"),),
    "datasets": (
        ("hazbot", "dataset", "--policy", "idm", "--episodes", "1", "--out", "corridor-idm-v0"),
    ),
    "robots": (("python", "-c", ROBOTS),),
    "live": (("python", "-c", LIVE),),
    "cluster": (("python", "-c", "import hazbot_gym.evaluation.ray_cluster"),),
}


def main() -> None:
    """Run the checks that are asked for, all by default."""
    checks: dict[str, Callable[[str], None]] = {
        check.__name__: check
        for check in (metadata, pythons, sdist, readme, extras, lowest, newest)
    }
    parser = argparse.ArgumentParser(description="Release check.")
    parser.add_argument("checks", nargs="*", help=f"any of {', '.join(checks)}; default all")
    parser.add_argument("--python", default=sys.executable, help="of the clean environments")
    names = [extra for extra in USES if extra]
    parser.add_argument("--without", nargs="*", default=(), choices=names, help="extras left out")
    given = parser.parse_args()
    checks["extras"] = partial(extras, without=given.without)
    if unknown := set(given.checks) - set(checks):
        parser.error(f"given {', '.join(unknown)}, allowed are {', '.join(checks)}")
    build()
    for name in given.checks or checks:
        print(f"== {name}", flush=True)
        checks[name](given.python)
    print("release check: passed")


def build() -> None:
    """Build the sdist, and from it the wheel."""
    shutil.rmtree(DIST, ignore_errors=True)
    if not (BIN / "uv").exists():
        run(sys.executable, "-m", "venv", HOME / "tools")
        run(BIN / "pip", "install", "--quiet", *TOOLS)
    run(BIN / "python", "-m", "build", "--outdir", DIST, ROOT)


def metadata(_: str) -> None:
    """Check pyproject.toml, and the metadata and contents of both files."""
    run(BIN / "validate-pyproject", ROOT / "pyproject.toml")
    run(BIN / "twine", "check", "--strict", *DIST.iterdir())
    run(BIN / "check-wheel-contents", wheel())


def pythons(_: str) -> None:
    """Find wheels of all dependencies for each Python of the classifiers; nothing is installed."""
    extras = [f"--extra={extra}" for extra in USES if extra]
    with (ROOT / "pyproject.toml").open("rb") as file:
        classifiers = tomllib.load(file)["project"]["classifiers"]
    for version in (name.rpartition(" :: 3.")[2] for name in classifiers if " :: 3." in name):
        run(
            BIN / "uv", "pip", "compile", "--quiet", f"--python-version=3.{version}",
            "--only-binary=:all:", "--upgrade", *extras, f"--output-file={HOME / 'wheels.txt'}",
            ROOT / "pyproject.toml",
        )  # fmt: skip


def sdist(python: str) -> None:
    """Install from the sdist, without extras, and run an episode."""
    (source,) = DIST.glob("*.tar.gz")
    install(python, source)
    use(*USES[""][1])


def readme(python: str) -> None:
    """Run the README's Python snippets on the wheel with the extra ``all``."""
    install(python, f"{wheel()}[all]", "pytest", "hypothesis")
    snippets = ROOT / "tests" / "docs" / "test_snippets.py"
    use("python", "-m", "pytest", "-q", "-c", ROOT / "pyproject.toml", snippets, "-k", "README")


def extras(python: str, without: Collection[str] = ()) -> None:
    """Use each extra where nothing else is installed."""
    for extra, commands in USES.items():
        if extra in without:
            continue
        install(python, f"{wheel()}[{extra}]" if extra else wheel())
        for command in commands:
            use(*command)


def lowest(python: str) -> None:
    """Run the fast tests with the lowest versions that pyproject.toml declares."""
    fast_tests(python, "lowest-direct")


def newest(python: str) -> None:
    """Run the fast tests with the newest versions that there are."""
    fast_tests(python, "highest")


def fast_tests(python: str, resolution: str) -> None:
    """Run the fast tests in the checkout, whose folders they need; torch is that of constraints."""
    versions = (ROOT / "constraints.txt").read_text().splitlines()
    torch = next(line for line in versions if line.startswith("torch=="))
    wanted = "--editable", f"{ROOT}[all]", torch, "pytest>=8", "hypothesis>=6.100"
    install(python, "--resolution", resolution, *wanted, constraints="/dev/null")
    run(CLEAN / "bin" / "python", *TESTS)


def wheel() -> Path:
    """Return the wheel."""
    (found,) = DIST.glob("*.whl")
    return found


def install(python: str, *wanted: str | Path, constraints: str = "constraints.txt") -> None:
    """Make the clean environment anew, with some requirements."""
    uv = BIN / "uv"
    run(uv, "venv", "--quiet", "--clear", "--python", python, CLEAN)
    run(uv, "pip", "install", "--quiet", "--python", CLEAN, "--constraints", constraints, *wanted)


def use(program: str, *arguments: str | Path) -> None:
    """Run a program of the clean environment, in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        run(CLEAN / "bin" / program, *arguments, folder=Path(folder))


def run(*command: str | Path, folder: Path = ROOT) -> None:
    """Run a command without the checkout on the module path; end with its message if it fails."""
    print("+", *(str(part).strip().replace("\n", "; ") for part in command), flush=True)
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    clean["NUMBA_CACHE_DIR"] = str(HOME / "numba")  # what is compiled serves all the environments
    if links := os.environ.get("PIP_FIND_LINKS"):
        clean.setdefault("UV_FIND_LINKS", links)
    done = subprocess.run([str(part) for part in command], cwd=folder, env=clean, check=False)
    if done.returncode:
        sys.exit(f"release check: failed with {done.returncode}")


if __name__ == "__main__":
    main()
