from __future__ import annotations

import importlib
import math
import sys
from pathlib import Path
from types import ModuleType

import numba
import numpy as np
import pytest

from hazbot_gym.core import jit, notice, sources
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
        for module in (jit, notice, sources):
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
