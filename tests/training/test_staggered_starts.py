"""Staggered starts: worlds begin in different phases, and every counter knows it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.vec_envs import make_envs
from tests.refusals import refused

WORLDS = 24
EMPTY: dict[str, Any] = {"people": {"count": [0, 0]}}


def made(**changes: Any) -> Any:
    values: dict[str, Any] = {"worlds": WORLDS, "staggered_starts": True, **changes}
    envs = make_envs(TrainConfig.model_validate(values))
    envs.seed(5)
    return envs


def full_speed() -> Any:
    return np.ones((WORLDS, 1), np.float32)


def test_phases_spread_over_the_path() -> None:
    envs = made()
    envs.reset()
    worlds = envs.unwrapped
    share = worlds.advance * 0.1 / worlds.times_free_s
    assert np.histogram(share, 3, (0.0, 1.0))[0].min() >= 3
    assert (worlds.advance <= worlds.steps + 1e-9).all()


@pytest.mark.parametrize("env", ["Corridor-v1", ["Corridor-v1", "Circle-v1"]])
def test_a_path_takes_as_many_decisions_as_without(env: Any) -> None:
    counts = {}
    for staggered in (True, False):
        envs = made(env=env, overrides=EMPTY, staggered_starts=staggered)
        envs.reset()
        worlds, found = envs.unwrapped, np.zeros(WORLDS)
        ahead = worlds.steps.copy()
        for step in range(1, 1200):
            *_, dones, _ = envs.step(full_speed())
            first = dones & (found == 0.0)
            found[first] = step + ahead[first]
            if found.all():
                break
        counts[staggered] = found
        assert ahead.any() == staggered
    assert (counts[True] == counts[False]).all()


def test_episodes_that_are_not_seen_whole_are_not_monitored() -> None:
    envs = made(overrides=EMPTY)
    envs.reset()
    ahead, ends = envs.unwrapped.steps.copy(), np.zeros(WORLDS, int)
    for _ in range(900):
        *_, dones, infos = envs.step(full_speed())
        for i in np.flatnonzero(dones):
            assert ("episode" in infos[i]) == (ends[i] > 0 or ahead[i] == 0)
            ends[i] += 1
    assert ends.min() >= 2


def test_equal_seeds_give_equal_starts() -> None:
    first, second = made(), made()
    assert (first.reset() == second.reset()).all()
    assert (first.unwrapped.steps == second.unwrapped.steps).all()
    other = made()
    other.seed(6)
    other.reset()
    assert (first.unwrapped.steps != other.unwrapped.steps).any()


def test_discrete_speeds_start_at_the_highest_level() -> None:
    envs = made(algorithm="dqn", overrides={**EMPTY, "action_type": "discrete"})
    envs.reset()
    assert envs.unwrapped.advance.max() > 10.0


def test_the_exact_engine_has_no_staggered_starts() -> None:
    with refused("staggered_starts ... 'pymunk' ... 'batched'"):
        load_training(None, engine="pymunk", staggered_starts=True)
