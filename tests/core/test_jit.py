from __future__ import annotations

import errno
import importlib
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import caching

from hazbot_gym.core import compile_message, jit, sources
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.jit import kernel, lean_kernel, scalar
from hazbot_gym.core.state import Floats

FORMULA = """
from toy.core.jit import scalar

@scalar
def formula(x):
    return x + {increment}
"""
LOOP = """
from toy.core.jit import kernel
from toy.formula import formula

@kernel
def loop(values):
    for i in range(values.shape[0]):
        values[i] = formula(values[i])
"""


@scalar
def wave(x: float, y: float) -> float:
    return math.sin(3.0 * x) * math.exp(-abs(y)) + (x - 7.0) % 2.0


@kernel
def waves(points: Floats, out: Floats) -> None:
    for i in range(points.shape[0]):
        out[i] = wave(points[i, 0], points[i, 1])


@lean_kernel
def lean_waves(points: Floats, out: Floats) -> None:
    for i in range(points.shape[0]):
        out[i] = wave(points[i, 0], points[i, 1])


@kernel
def ratios(a: Floats, b: Floats, out: Floats) -> None:
    for i in range(a.shape[0]):
        out[i] = a[i] / b[i]


class Toy:
    """A package of one formula and one kernel that calls it, with this project's jit module."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "toy"
        (self.root / "core").mkdir(parents=True)
        for module in (compile_message, jit, sources):
            text = Path(str(module.__file__)).read_text().replace("hazbot_gym.", "toy.")
            (self.root / "core" / f"{module.__name__.rpartition('.')[2]}.py").write_text(text)
        for file, text in {"__init__": "", "core/__init__": "", "loop": LOOP}.items():
            (self.root / f"{file}.py").write_text(text)
        self.write_formula(1)

    def write_formula(self, increment: int) -> None:
        (self.root / "formula.py").write_text(FORMULA.format(increment=increment))

    def import_afresh(self) -> ModuleType:
        for name in [name for name in sys.modules if name.split(".")[0] == "toy"]:
            del sys.modules[name]
        importlib.invalidate_caches()
        return importlib.import_module("toy.loop")


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Toy:
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")  # whatever NUMBA_CACHE_DIR says
    return Toy(tmp_path)


def test_formula_gives_the_same_from_python_and_from_a_kernel() -> None:
    points = np.random.default_rng(0).normal(size=(200, 2))
    out = np.empty(len(points))

    waves(points, out)

    assert out == pytest.approx([wave(x, y) for x, y in points.tolist()], rel=1e-14, abs=1e-14)


def test_formula_stays_plain_python() -> None:
    assert type(wave) is type(lambda: 0)


def test_kernel_divides_by_zero_without_complaint() -> None:
    out = np.empty(3)

    ratios(np.array([1.0, -1.0, 0.0]), np.zeros(3), out)

    assert out == pytest.approx([math.inf, -math.inf, math.nan], nan_ok=True)


def test_lean_kernel_gives_the_same_results() -> None:
    points = np.random.default_rng(0).normal(size=(20, 2))
    plain, lean = np.empty(20), np.empty(20)

    waves(points, plain)
    lean_waves(points, lean)

    assert lean.tolist() == plain.tolist()


def test_binary_is_kept_on_disk_while_the_package_stays_the_same(toy: Toy) -> None:
    for hits in (0, 1):
        loop = toy.import_afresh().loop
        loop(np.zeros(1))
        assert sum(loop.stats.cache_hits.values()) == hits


def test_changed_formula_reaches_the_kernels_of_other_files(toy: Toy) -> None:
    values = np.zeros(1)
    toy.import_afresh().loop(values)
    toy.write_formula(20)

    toy.import_afresh().loop(values)

    assert values[0] == 21.0


def test_stamp_is_numbas_own_and_that_of_the_files_that_are_imported(toy: Toy) -> None:
    numbas = numba.njit(cache=True)(toy.import_afresh().loop.py_func)

    stamp = toy.import_afresh().loop._cache._cache_file._source_stamp

    assert stamp == (
        numbas._cache._cache_file._source_stamp,
        sources.digest(toy.root, toy.root / "loop.py"),
    )


NOUN = """
from typing import NamedTuple

class Noun(NamedTuple):
    value: float
"""
READER = """
from toy.core.jit import kernel

@kernel
def read(noun):
    return noun.value
"""


def test_a_cache_of_a_version_with_other_classes_is_passed_over(toy: Toy) -> None:
    """After an upgrade in place the types of old arguments may not be importable any more."""
    (toy.root / "reader.py").write_text(READER)
    for name in ("before", "after"):
        (toy.root / f"{name}.py").write_text(NOUN)
        toy.import_afresh()
        noun = importlib.import_module(f"toy.{name}").Noun(3.0)
        assert importlib.import_module("toy.reader").read(noun) == 3.0
        (toy.root / f"{name}.py").unlink()


@pytest.fixture
def nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave numba no folder beside the package or in the user's cache, as for another user."""
    named_by_the_user = caching.CacheImpl._locator_classes[:1]
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", named_by_the_user)


def runs(toy: Toy) -> ModuleType:
    """Return the toy afresh after its kernel has run."""
    module, values = toy.import_afresh(), np.zeros(1)
    module.loop(values)
    assert values[0] == 1.0
    return module


def test_without_a_writable_cache_binaries_are_kept_in_a_private_temporary_folder(
    toy: Toy, nowhere: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for hits in (0, 1):
        assert sum(runs(toy).loop.stats.cache_hits.values()) == hits
    (folder,) = tmp_path.glob("toy-*")
    assert folder.stat().st_mode & 0o777 == 0o700
    said = [line for line in caplog.messages if str(folder) in line]
    assert len(said) == 2  # one in each run
    assert "NUMBA_CACHE_DIR" in said[0]
    assert numba.config.CACHE_DIR == ""


@pytest.mark.parametrize("trap", ["missing", "open", "link", "file"])
def test_a_temporary_folder_that_others_could_write_is_not_used(
    trap: str, toy: Toy, nowhere: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    folder = tmp_path / "temporary"
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    mine = folder / f"toy-{os.getuid()}"
    if trap != "missing":
        folder.mkdir()
    if trap == "open":
        mine.mkdir()
        mine.chmod(0o777)
    elif trap == "link":
        (tmp_path / "of_another").mkdir(mode=0o700)
        mine.symlink_to(tmp_path / "of_another")
    elif trap == "file":
        mine.write_text("")
    runs(toy)
    assert not list(tmp_path.rglob("*.nb?"))
    assert any("so each run compiles" in line for line in caplog.messages)


@pytest.mark.parametrize(
    "damage", [lambda data: data[:9], lambda data: b"", lambda data: b"x" * 99]
)
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_binary_is_compiled_anew(toy: Toy, ending: str, damage: Any) -> None:
    runs(toy)
    (file,) = toy.root.rglob(f"*.{ending}")
    file.write_bytes(damage(file.read_bytes()))
    assert sum(runs(toy).loop.stats.cache_hits.values()) == 0
    assert sum(runs(toy).loop.stats.cache_hits.values()) == 1


def test_a_full_disk_costs_the_binary_alone(toy: Toy, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(caching.IndexDataCacheFile, "_save_data", full)
    runs(toy)


PLAIN = """
import sys
import gymnasium
import numpy as np
from hazbot_gym.core import fuzzy_pid
fuzzy_pid.gain_table = lambda _="textbook": np.load(sys.argv[2])
from hazbot_gym import policies
from hazbot_gym.envs.vector import CorridorVectorEnv

walker = {"x_m": 3.0, "y_m": 0.3, "vx_mps": -0.5, "vy_mps": 0.0}
options = {"people": {"model": "scripted", "walkers": [walker]}, "place": sys.argv[1], "gas": {}}
env = gymnasium.make("hazbot_gym/Corridor-v1", **options)
worlds = CorridorVectorEnv(2, threads=1, **options)
numbers, (seen, _) = [*env.reset(seed=3)[0]], worlds.reset(seed=3)
numbers += seen.ravel().tolist()
for _ in range(3):
    observation, reward, *_ = env.step(np.float32([0.5]))
    seen, rewards, *_ = worlds.step(np.full((2, 1), 0.5, np.float32))
    numbers += [*observation, reward, *seen.ravel(), *rewards]
for name in policies.names():
    for given in (seen, np.ascontiguousarray(seen[:, :26])):
        if name not in ("learned", "shielded", "ppo_prices"):
            numbers += policies.make(name).predict(given)[0].ravel().tolist()
print(*(float(number) for number in numbers))
"""
SHORT = "{name: short, walls: [[-2, 1.2, 4, 1.2]], path: {points: [[0, 0], [1, 0]]}}"


@pytest.mark.slow
def test_everything_runs_as_plain_python_with_the_same_numbers(tmp_path: Path) -> None:
    """The way to step through a kernel with a debugger."""
    place, table = tmp_path / "short.yaml", tmp_path / "table.npy"
    place.write_text(SHORT)
    np.save(table, gain_table())  # half a minute in plain Python; test_fuzzy_pid.py compares both
    numbers = [
        subprocess.run(
            [sys.executable, "-c", PLAIN, str(place), str(table)],
            env={**os.environ, "NUMBA_DISABLE_JIT": disable},
            check=True,
            capture_output=True,
            text=True,
        ).stdout.split()
        for disable in ("0", "1")
    ]
    assert len(numbers[0]) > 400
    assert [float(x) for x in numbers[1]] == pytest.approx([float(x) for x in numbers[0]], abs=1e-6)
