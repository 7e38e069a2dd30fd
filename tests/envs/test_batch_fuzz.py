"""Many random decisions in the batched engine: no NaN, nothing outside its space, memory flat."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.state import PRESENT
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.task.outcome import OUTCOME_NAMES

WORLDS = 250
OPTIONS: list[dict[str, Any]] = [
    {},
    {"tier": "sonar", "drive": {"reflex_stop_m": 0.5}},
    {"tier": "privileged", "people": {"model": "scripted"}},
    {"people": {"model": "seeded"}, "sensors": {"ultrasonic": {"cross_talk": 0.3}}},
    {"people": {"count": [0, 10]}, "sensors": {"tracker": {"latency_steps": 4, "dropout": 0.3}}},
    {"action_type": "discrete", "drive": {"wheel_loop": "pid", "plant": "C"}},
    {"drive": {"latency_steps": 3, "line_sensor": {"pitch_m": 0.01}}, "place": "circle"},
]


def resident_bytes() -> int:
    """Return the memory of the process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def play(envs: CorridorVectorEnv, steps: int, seed: int) -> set[str]:
    """Drive at random, check all that is returned, and tell how episodes ended."""
    envs.action_space.seed(seed)
    observations, _ = envs.reset(seed=seed)
    ends: set[str] = set()
    weights = np.abs(np.array(envs.config.reward)).sum()
    for _ in range(steps):
        assert np.isfinite(observations).all()
        assert envs.observation_space.contains(observations)
        actions = envs.action_space.sample()
        observations, rewards, terminated, truncated, info = envs.step(actions)
        assert (np.abs(rewards) <= weights).all()  # terms lie in [0, 1]; False for NaN
        assert ((info["cost"] >= 0.0) & (info["cost"] <= 2.0)).all()
        ends |= set(info["outcome"][terminated | truncated])
    people = envs.state().people
    there = people[people["status"] == PRESENT]
    assert all(np.isfinite(there[name]).all() for name in ("x", "y", "vx", "vy", "blocked"))
    return ends


def problems(rounds: int) -> Iterator[tuple[str, dict[str, Any], int]]:
    """Yield (name, options, seed): every environment, the options in turn."""
    for k in range(rounds):
        for row, name in enumerate(ENVIRONMENTS):
            yield name, OPTIONS[(row + k) % len(OPTIONS)], 1_000_000 * k + 100_000 * row


def fuzz(decisions: int, rounds: int) -> set[str]:
    """Take a number of decisions, spread over all environments."""
    ends: set[str] = set()
    steps = decisions // (WORLDS * rounds * len(ENVIRONMENTS))
    for name, options, seed in problems(rounds):
        ends |= play(
            CorridorVectorEnv(WORLDS, preset=ENVIRONMENTS[name][1], **options), steps, seed
        )
    return ends


def test_random_decisions_stay_in_their_spaces() -> None:
    assert fuzz(200_000, rounds=1) <= set(OUTCOME_NAMES)


@pytest.mark.long
def test_ten_million_random_decisions_stay_in_their_spaces_and_in_memory() -> None:
    fuzz(500_000, rounds=len(OPTIONS))  # everything is loaded and compiled
    gc.collect()
    before, start = resident_bytes(), time.perf_counter()
    ends = fuzz(10_000_000, rounds=len(OPTIONS))
    gc.collect()
    after = resident_bytes()
    print(
        f"{time.perf_counter() - start:.0f} s, {before / 1e6:.1f} MB before, "
        f"{after / 1e6:.1f} MB after, {sorted(ends)}"
    )
    assert after - before < 20_000_000
    assert ends == {"arrived", "contact_person", "timeout"}
