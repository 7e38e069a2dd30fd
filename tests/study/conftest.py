"""A benchmark's record without the minutes that measuring takes."""

from __future__ import annotations

import time
from typing import Any

import pytest

from hazbot_gym.study import bench, bench_once
from hazbot_gym.study.bench_cases import CARTPOLE, CARTPOLES, CORRIDOR, PEOPLE, WORLDS, batched


class Sleeper:
    """A case whose every call takes a tenth of a millisecond, or a little more."""

    def __init__(self, size: int) -> None:
        self.size, self.calls = size, 0

    def run(self, calls: int) -> None:
        self.calls += calls
        until = time.perf_counter() + 1e-4 * calls
        while time.perf_counter() < until:
            pass


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    sizes = {CARTPOLE: 1, CARTPOLES: 1024, CORRIDOR: 1}
    sizes |= {batched(worlds, people): worlds for worlds in WORLDS for people in PEOPLE}
    cases = {name: Sleeper(size) for name, size in sizes.items()}
    monkeypatch.setattr(bench, "make_cases", lambda spread: (cases, ["SB3 adapter left out"]))
    monkeypatch.setattr(bench_once, "_first_episode_s", lambda engine, environment: 1.25)
    effort = bench.QUICK._replace(turns=2, turn_s=1e-3, evaluations=1, memory_steps=2)
    monkeypatch.setattr(bench, "EPISODES", 3)
    return bench.bench(effort._replace(is_compiling=True))
