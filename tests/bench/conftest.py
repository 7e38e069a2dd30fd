"""A benchmark's record without the minutes that measuring takes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from hazbot_gym.bench import once
from hazbot_gym.bench import run as bench
from hazbot_gym.bench.cases import (
    CARTPOLE,
    CARTPOLES,
    CORRIDOR,
    ONE_THREAD,
    PEOPLE,
    SHIPPED,
    WITH_GAS,
    WITHOUT_PEOPLE,
    WITHOUT_WHEELS,
    WORLDS,
    asking,
    batched,
)


class Clock:
    """A clock that cases move on."""

    def __init__(self) -> None:
        self.now = 0.0

    def perf_counter(self) -> float:
        return self.now


class Timed:
    """A case whose every call takes a tenth of a millisecond, and is noted."""

    def __init__(self, clock: Clock, size: int, name: str = "", order: list[str] | None = None):
        self.clock, self.size = clock, size
        self.name, self.order = name, [] if order is None else order

    def run(self, calls: int) -> None:
        self.order.append(self.name)
        self.clock.now += 1e-4 * calls


@pytest.fixture
def timed(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Timed]:
    """Return a function that makes cases that move the benchmark's clock."""
    clock = Clock()
    monkeypatch.setattr(bench, "time", clock)
    return partial(Timed, clock)


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch, timed: Callable[..., Timed]) -> dict[str, Any]:
    sizes = {CARTPOLE: 1, CARTPOLES: 1024, CORRIDOR: 1}
    sizes |= {batched(worlds, people): worlds for worlds in WORLDS for people in PEOPLE}
    sizes |= {asking(SHIPPED): 2048, ONE_THREAD: 100, WITHOUT_PEOPLE: 200, WITHOUT_WHEELS: 500}
    sizes[WITH_GAS] = 80
    cases = {name: timed(size) for name, size in sizes.items()}
    monkeypatch.setattr(bench, "make_cases", lambda spread: (cases, ["SB3 adapter left out"]))
    monkeypatch.setattr(once, "first_episode_s", lambda engine, environment: 1.25)
    effort = bench.QUICK._replace(turns=2, turn_s=1e-3, evaluations=1, memory_steps=2)
    monkeypatch.setattr(bench, "EPISODES", 3)
    return bench.bench(effort._replace(is_compiling=True))
