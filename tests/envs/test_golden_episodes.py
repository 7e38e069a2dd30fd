"""One episode of every id, as it was when the id was given its version.

A change that moves these numbers changes what learners meet: the ids then become -v1, and the class
docstring of ``CorridorEnv`` says so under Version History. After such a change, or before the first
release, write them anew with

    HAZBOT_UPDATE_GOLDEN=1 .venv/bin/python -m pytest tests/envs/test_golden_episodes.py
"""

from __future__ import annotations

import functools
import json
import math
import os
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE

GOLDEN = Path(__file__).parents[1] / "reference" / "golden_episodes.json"
SEED, DECISIONS = 2026, 150
NOTED = (0, 1, 20, 75)  # decisions after which the state is written down, besides the last
TOLERANCE = 1e-6


def action(decision: int) -> Any:
    """Return full speed with two slow waves in it."""
    return np.array([0.4 + 0.6 * math.sin(0.13 * decision) * math.cos(0.021 * decision)])


def state(env: CorridorEnv, observation: Any, total: float) -> dict[str, Any]:
    """Return a few numbers that everything has an influence on."""
    s = env.snapshot()
    return {
        "time_s": s.time_s,
        "robot": [s.x, s.y, s.theta, s.speed_mps, s.y_e],
        "people": [len(s.people), *(float(s.people[f].sum()) for f in ("x", "y", "vx", "vy"))],
        "observation": [float(observation.sum(dtype=np.float64)), float(np.abs(observation).max())],
        "return": total,
    }


def episode(env_id: str) -> dict[str, Any]:
    """Return the episode's key, some of its states, and how it ended."""
    env = gymnasium.make(env_id).unwrapped
    assert isinstance(env, CorridorEnv)
    observation, info = env.reset(seed=SEED)
    key, total, states = str(info["scenario_key"]), 0.0, []
    for decision in range(DECISIONS):
        if decision in NOTED:
            states.append(state(env, observation, total))
        observation, reward, terminated, truncated, info = env.step(action(decision))
        total += float(reward)
        if terminated or truncated:
            break
    states.append(state(env, observation, total))
    return {"scenario_key": key, "states": states, "outcome": info.get("outcome", "running")}


@functools.cache
def golden() -> dict[str, Any]:
    """Return the written numbers, after writing them anew if that is asked for."""
    if os.environ.get("HAZBOT_UPDATE_GOLDEN"):
        ids = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
        content = {"seed": SEED, "episodes": {env_id: episode(env_id) for env_id in ids}}
        GOLDEN.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    content = json.loads(GOLDEN.read_text(encoding="utf-8"))
    assert content["seed"] == SEED
    episodes: dict[str, Any] = content["episodes"]
    return episodes


def numbers(states: list[dict[str, Any]]) -> list[float]:
    """Return all numbers of the states in a row."""
    return [
        float(value)
        for each in states
        for values in each.values()
        for value in (values if isinstance(values, list) else [values])
    ]


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_id_s_episode_is_still_the_one_of_its_version(name: str) -> None:
    written, now = golden()[f"{NAMESPACE}/{name}"], episode(f"{NAMESPACE}/{name}")
    assert now["scenario_key"] == written["scenario_key"]
    assert now["outcome"] == written["outcome"]
    assert numbers(now["states"]) == pytest.approx(numbers(written["states"]), abs=TOLERANCE)


def test_every_id_has_an_episode_and_nobody_else() -> None:
    assert set(golden()) == {f"{NAMESPACE}/{name}" for name in ENVIRONMENTS}
