"""The wheel stands on its own: built, installed outside the checkout, and run there."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parent.parent
ONE_EPISODE = """
import gymnasium, hazbot_gym
env = gymnasium.make("hazbot_gym/Corridor-v1", max_episode_steps=3)
env.reset(seed=0)
ended = False
while not ended:
    *_, terminated, truncated, info = env.step(env.action_space.high)
    ended = terminated or truncated
print(hazbot_gym.__file__, info["outcome"])
"""

pytestmark = pytest.mark.slow


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command without the checkout on the module path and return what it printed."""
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=clean, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=CHECKOUT)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def bin_folder(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the programs of an environment that has the wheel and nothing of the checkout.

    The wheel is really installed. Its dependencies are not downloaded again: a path file points at
    the packages of the environment that runs this test. Path files are not read in folders that
    are named by path files, so the editable install of the checkout there stays out of sight.
    """
    home = tmp_path_factory.mktemp("env")
    venv.create(home, with_pip=False)
    (site,) = home.glob("lib/python*/site-packages")
    pip = [sys.executable, "-m", "pip", "--python", home / "bin" / "python"]
    run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel, cwd=home)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home / "bin"


def test_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    tops = {name.split("/")[0] for name in names}

    assert {top for top in tops if not top.endswith(".dist-info")} == {"hazbot_gym"}
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]
    packaged = {name for name in names if name.startswith("hazbot_gym/")}
    sources = (CHECKOUT / "hazbot_gym").rglob("*.py")
    assert packaged >= {str(source.relative_to(CHECKOUT)) for source in sources}


def test_installed_wheel_lists_environments(bin_folder: Path, tmp_path: Path) -> None:
    assert "hazbot_gym/Corridor-v1" in run(bin_folder / "hazbot", "list", cwd=tmp_path)


def test_installed_wheel_runs_an_episode(bin_folder: Path, tmp_path: Path) -> None:
    place, outcome = run(bin_folder / "python", "-c", ONE_EPISODE, cwd=tmp_path).split()

    assert Path(place).is_relative_to(bin_folder.parent)
    assert outcome in {"arrived", "contact_person", "contact_wall", "timeout"}


def test_installed_wheel_exports_c(bin_folder: Path, tmp_path: Path) -> None:
    command = ("export", "--policy", "fuzzy_expert", "--format", "c", "--out", tmp_path / "there")
    run(bin_folder / "hazbot", *command, cwd=tmp_path)

    assert (tmp_path / "there" / "hazbot_policy.c").is_file()
