"""Import rules between packages: the rules of the house, read from the source."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import hazbot_gym

PACKAGE = Path(hazbot_gym.__file__).parent

# What each room may import besides itself, the errors and the package's version. A room inside a
# room has rules of its own.
ENGINES = ("envs", "sim", "task", "config", "core", "utils")
MIDDLE = ("training", "evaluation", "policies", *ENGINES)
BELOW = {
    "__init__": ("envs", "training", "evaluation", "runtime", "policies", "task", "config", "core"),
    "__main__": ("cli",),
    "cli": ("bench", "export", "live", "paper", "viewer", "calibration", "study", *MIDDLE),
    "bench": ("study", "export", "runtime", *MIDDLE),
    "paper": ("evaluation", "policies", *ENGINES),
    "study": MIDDLE,
    # A view: it reads records, and neither computes statistics nor simulates.
    "study.report": (
        *(f"study.{name}" for name in ("answer", "config", "costs", "default_policies")),
        *(
            f"study.{name}"
            for name in ("headline", "replay_records", "results", "set_descriptions", "store")
        ),
        "study.terminal_tables",
        *(f"study.summary.{name}" for name in ("COMPARED", "LEVELS")),
        "evaluation.statistics.pareto.AXES",
        "evaluation.prices.RETURNS",
        "evaluation.episode",
        "core",
        "utils",
    ),
    "viewer": ("evaluation", "policies", *ENGINES),
    "live": ("evaluation", "policies", *ENGINES),
    "export": ("runtime", "policies", "task.observation", "core", "utils"),
    "runtime": ("policies", "task.action", "task.observation", "config", "core", "utils"),
    "training": ("evaluation", "policies", *ENGINES),
    "calibration": ("sim", "task", "config", "core", "utils"),
    "evaluation": ("policies", *ENGINES),
    "evaluation.statistics": ("core.state",),
    "envs": ("sim", "task", "config", "core", "utils"),
    "policies": ("task.action", "task.observation", "core", "utils"),
    "sim": ("config", "core", "utils"),
    "task": ("config", "core", "utils"),
    "config": ("core", "utils"),
    "core": (),
    "utils": (),
    "errors": (),
}

TRAINING = tuple(
    f"training.{name}"
    for name in (
        "action_repeat",
        "algorithms",
        "array_ppo",
        "asymmetric_critic",
        "callbacks",
        "checkpoints",
        "combined_envs",
        "dagger",
        "episode_monitor",
        "feature_mask",
        "imitation",
        "logging",
        "ppo_lagrangian",
        "priced_rewards",
        "residual_envs",
        "run",
        "shaping",
        "staggered_starts",
        "vec_envs",
    )
)

# The only modules that may import a heavy library; a room's name stands for all its modules.
HOMES = {
    "pymunk": ("sim.world",),
    "pettingzoo": ("envs.robots",),
    "pygame": ("envs.canvas", "envs.window"),
    "imageio_ffmpeg": ("viewer.video",),
    "PIL": ("envs.canvas", "viewer.video", "task.wall_files"),
    "shapely": ("task.wall_files", "task.track_formats"),
    "skfuzzy": ("policies.fuzzy_system",),
    "torch": TRAINING,
    "stable_baselines3": ("envs.sb3", "envs.sb3_singles", *TRAINING, "policies.from_sb3"),
    "sb3_contrib": ("training.algorithms", "training.run", "policies.from_sb3"),
    "pandas": ("study", "evaluation.statistics", "task.track_formats"),
    "h5py": ("task.track_formats.juelich", "evaluation.minari_dataset"),
    "minari": ("evaluation.minari_dataset",),
    "pyarrow": ("study.store",),
    "matplotlib": ("paper.sections", "paper.plot_style"),
    "plotly": ("study.report.figures",),
    "jinja2": ("study.report.page", "paper.page", "export.c_code"),
    "onnx": ("export.onnx_file",),
    "onnxruntime": ("export.check",),
    "numba": ("core", "export.wasm"),
    "optuna": ("study.proposals",),
    "ray": ("evaluation.ray_cluster",),
    "typer": ("cli",),
    "starlette": ("live.server",),
    "uvicorn": ("live.server",),
    "websockets": ("live.server",),
    "anyio": ("live.server",),
}


def imported_modules(source: Path, package: Path) -> set[str]:
    """Return the full names of what a file imports, at any depth; ``from a import b`` gives a.b."""
    names = set()
    here = (package.name, *source.relative_to(package).parent.parts)
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else ()
            parent = ".".join((*base, *(node.module or "").split("."))).strip(".")
            names.update(f"{parent}.{alias.name}" for alias in node.names)
    return names


def is_within(name: str, rooms: tuple[str, ...]) -> bool:
    return any(name == room or name.startswith(room + ".") for room in rooms)


def room_of(module: str) -> str:
    """Return the innermost room with rules that a module is in."""
    return max((room for room in BELOW if is_within(module, (room,))), key=len)


def violations(package: Path) -> list[str]:
    """Return a line for each import that the rules forbid."""
    found = []
    for source in sorted(package.rglob("*.py")):
        module = ".".join(source.relative_to(package).with_suffix("").parts)
        room = room_of(module)
        allowed = (room, *BELOW[room], "errors", "__version__")
        for name in sorted(imported_modules(source, package)):
            library, _, rest = name.partition(".")
            if library == package.name and rest and not is_within(rest, allowed):
                found.append(f"{module} imports {rest}")
            elif library in HOMES and not is_within(module, HOMES[library]):
                found.append(f"{module} imports {library}")
    return found


def test_imports_point_one_way_and_heavy_libraries_stay_at_home() -> None:
    assert violations(PACKAGE) == []


@pytest.mark.parametrize(
    ("file", "line", "complaint"),
    [
        ("core/pid.py", "from hazbot_gym.task import reward", "core.pid imports task.reward"),
        ("core/pid.py", "from ..task.reward import terms", "core.pid imports task.reward.terms"),
        ("task/reward.py", "import hazbot_gym.sim.world", "task.reward imports sim.world"),
        (
            "policies/base.py",
            "from hazbot_gym.task import reward",
            "policies.base imports task.reward",
        ),
        ("envs/corridor.py", "from hazbot_gym import policies", "envs.corridor imports policies"),
        ("task/reward.py", "def f():\n    import torch.nn", "task.reward imports torch"),
        ("sim/batched_worlds.py", "from pymunk import Body", "sim.batched_worlds imports pymunk"),
        (
            "evaluation/metrics.py",
            "from hazbot_gym.study import summary",
            "evaluation.metrics imports study.summary",
        ),
        (
            "evaluation/statistics/pareto.py",
            "from hazbot_gym.evaluation import metrics",
            "evaluation.statistics.pareto imports evaluation.metrics",
        ),
        ("training/run.py", "from hazbot_gym import study", "training.run imports study"),
        (
            "study/report/figures.py",
            "from hazbot_gym.evaluation.statistics.pareto import dominated",
            "study.report.figures imports evaluation.statistics.pareto.dominated",
        ),
        (
            "study/report/page.py",
            "from hazbot_gym.study import replays",
            "study.report.page imports study.replays",
        ),
        ("study/report/maps.py", "import hazbot_gym.envs", "study.report.maps imports envs"),
        ("viewer/watch.py", "import hazbot_gym.training", "viewer.watch imports training"),
        ("calibration/fit.py", "import hazbot_gym.envs", "calibration.fit imports envs"),
        ("utils/files.py", "import hazbot_gym.core.state", "utils.files imports core.state"),
        ("runtime/people.py", "import hazbot_gym.sim.world", "runtime.people imports sim.world"),
    ],
)
def test_checker_catches_a_planted_violation(
    tmp_path: Path, file: str, line: str, complaint: str
) -> None:
    planted = tmp_path / "hazbot_gym" / file
    planted.parent.mkdir(parents=True)
    planted.write_text(line + "\n")

    assert violations(tmp_path / "hazbot_gym") == [complaint]


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("policies/base.py", "from hazbot_gym.task.observation import Layout"),
        ("policies/base.py", "from hazbot_gym.task import observation"),
        ("sim/world.py", "import pymunk"),
        ("core/pid.py", "from hazbot_gym.errors import InvalidInput"),
        ("study/report/page.py", "from hazbot_gym import __version__"),
    ],
)
def test_checker_lets_allowed_imports_pass(tmp_path: Path, file: str, line: str) -> None:
    allowed = tmp_path / "hazbot_gym" / file
    allowed.parent.mkdir(parents=True)
    allowed.write_text(line + "\n")

    assert violations(tmp_path / "hazbot_gym") == []


def test_importing_the_package_loads_no_heavy_library() -> None:
    heavy = {*HOMES, "gymnasium", "pydantic", "yaml", "rich", "scipy"}
    command = "import sys, hazbot_gym; print(*sys.modules)"

    loaded = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True
    ).stdout.split()

    assert "hazbot_gym" in loaded
    assert heavy.isdisjoint(loaded)


def test_a_robot_s_runtime_loads_no_simulator() -> None:
    command = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "from hazbot_gym import SpeedController\n"
        "SpeedController('ppo', tier='sonar'); print(*sys.modules)"
    )

    loaded = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True
    ).stdout.split()

    assert "hazbot_gym.runtime.controller" in loaded
    simulator = {name for name in loaded if name.startswith(("hazbot_gym.sim", "gymnasium."))}
    assert simulator == set()
    assert {"pymunk", "torch", "pandas"}.isdisjoint(loaded)


def test_tables_are_parsed_by_what_is_imported_when_one_is_read() -> None:
    command = "import sys, hazbot_gym.task.scenario; print(*sys.modules)"

    loaded = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True
    ).stdout.split()

    assert "hazbot_gym.task.track_formats" in loaded
    assert {"pandas", "h5py", "shapely"}.isdisjoint(loaded)
