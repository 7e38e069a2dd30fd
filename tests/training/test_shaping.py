"""Shaped rewards: an episode's add up to its return less what a free drive earns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.training.config import TrainConfig
from hazbot_gym.training.vec_envs import make_envs

WORLDS, STEPS, SCALE = 6, 400, 0.2
SHORT: dict[str, Any] = {"max_episode_steps": 150, "reward": {"progress": 0.7, "arrival": 3.0}}


def made(**changes: Any) -> Any:
    values: dict[str, Any] = {"worlds": WORLDS, "reward_scale": SCALE, **changes}
    return make_envs(TrainConfig.model_validate(values))


def test_rewards_add_up_to_the_return_less_that_of_a_free_drive() -> None:
    # A place short enough for arrivals, and an horizon short enough for time-outs.
    overrides = {**SHORT, "place_options": {"length_m": 6.0}}
    envs = made(shaping="free_drive", overrides=overrides)
    envs.seed(3)
    envs.reset()
    total, rng, outcomes = np.zeros(WORLDS), np.random.default_rng(0), set()
    free = envs.unwrapped.times_free_s / 0.1
    for _ in range(STEPS):
        actions = rng.uniform(-0.6, 1.0, (WORLDS, 1)).astype(np.float32)
        actions[::2] = 1.0  # every other world arrives
        _, rewards, dones, infos = envs.step(actions)
        total += rewards / SCALE
        for i in np.flatnonzero(dones):
            at_start = 0.7 * free[i] + 3.0 * (150 - free[i]) * 0.1
            assert total[i] == pytest.approx(infos[i]["episode"]["r"] - at_start, abs=1e-3)
            assert not infos[i]["TimeLimit.truncated"]
            outcomes.add(infos[i]["outcome"])
            total[i], free[i] = 0.0, envs.unwrapped.times_free_s[i] / 0.1
    assert outcomes >= {"arrived", "timeout"}


def test_a_free_drive_at_nominal_speed_costs_nothing_until_it_arrives() -> None:
    envs = made(shaping="free_drive", overrides={"people": {"count": [0, 0]}})
    envs.reset()
    for t in range(100):
        _, rewards, _, _ = envs.step(np.ones((WORLDS, 1), np.float32))
        if t > 20:  # once it has got up to speed
            assert np.abs(rewards / SCALE).max() < 0.05
