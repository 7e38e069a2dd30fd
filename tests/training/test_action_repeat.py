"""Action repeat: one step is several decisions of the environment, and no reward is lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.vec_envs import make_envs
from tests.refusals import refused

WORLDS, REPEAT, STEPS = 6, 4, 60
LIVELY: dict[str, Any] = {"place": "doorway", "people": {"count": [2, 4]}, "max_episode_steps": 50}


def made(repeat: int, **changes: Any) -> Any:
    values: dict[str, Any] = {"worlds": WORLDS, "overrides": LIVELY, "action_repeat": repeat}
    envs = make_envs(TrainConfig.model_validate({**values, **changes}))
    envs.seed(4)
    return envs


def actions() -> Any:
    return np.random.default_rng(0).uniform(-0.2, 1.0, (STEPS, WORLDS, 1)).astype(np.float32)


@pytest.mark.parametrize("shaping", ["none", "free_drive"])
def test_a_step_is_several_decisions_with_one_action(shaping: str) -> None:
    repeated, single, ends = made(REPEAT, shaping=shaping), made(1, shaping=shaping), 0
    assert (repeated.reset() == single.reset()).all()
    given, taken = np.zeros(WORLDS), np.zeros(WORLDS)
    for action in actions():
        observations, rewards, dones, infos = repeated.step(action)
        given += rewards
        ended = np.zeros(WORLDS, bool)
        for _ in range(REPEAT):
            seen, new, over, told = single.step(action)
            taken += new
            for i in np.flatnonzero(over):
                assert infos[i]["episode"] == told[i]["episode"]
                assert (infos[i]["terminal_observation"] == told[i]["terminal_observation"]).all()
            ended |= over
        assert (observations == seen).all()
        assert (dones == ended).all()
        ends += dones.sum()
    early = repeated._early  # rewards of episodes that have just begun: of the next step
    assert given + early == pytest.approx(taken, abs=1e-4)
    assert ends > WORLDS


def test_learners_that_act_at_every_decision_refuse_it() -> None:
    with refused("imitation ... action_repeat 4 ... 1"):
        load_training(None, algorithm="dagger", action_repeat=4)
    with refused("lagrangian ... action_repeat 4 ... 1"):
        load_training(None, action_repeat=4, lagrangian={"limit": 1.0})
