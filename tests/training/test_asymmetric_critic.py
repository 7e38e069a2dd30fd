"""The critic sees the time left, the actor does not, and nobody who uses the policy needs it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch

from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.run import make_model
from hazbot_gym.training.vec_envs import make_envs


def config(**changes: Any) -> TrainConfig:
    values: dict[str, Any] = {"worlds": 3, "asymmetric_critic": True, "network": {"net_arch": [8]}}
    return load_training(None, **{**values, **changes})


def test_observations_end_with_the_time_left() -> None:
    envs = make_envs(config(overrides={"max_episode_steps": 20}))
    envs.seed(0)
    assert (envs.reset()[:, -1] == 1.0).all()
    for step in range(1, 21):
        observations, _, dones, infos = envs.step(-np.ones((3, 1), np.float32))
        if step < 20:
            assert observations[:, -1] == pytest.approx(1.0 - step / 20)
    assert dones.all()
    assert (observations[:, -1] == 1.0).all()
    assert infos[0]["terminal_observation"].shape == (52,)
    assert infos[0]["terminal_observation"][-1] == 0.0


def test_only_the_critic_looks_at_it() -> None:
    run = config()
    envs = make_envs(run)
    model = make_model(run, envs)
    early = torch.as_tensor(envs.reset())
    late = early.clone()
    late[:, -1] = 0.1
    policy: Any = model.policy
    means = [policy.get_distribution(each).distribution.mean for each in (early, late)]
    assert torch.equal(*means)
    assert not torch.equal(policy.predict_values(early), policy.predict_values(late))


def test_the_policy_answers_and_is_exported_without_it() -> None:
    run = config()
    envs = make_envs(run)
    model = make_model(run, envs)
    observations = envs.reset()
    whole, _ = model.predict(observations, deterministic=True)
    without, _ = model.predict(observations[:, :-1], deterministic=True)
    assert np.array_equal(whole, without)
    actor = actor_of(model)
    assert actor.width == 51
    assert actor.act(observations[:, :-1])[0] == pytest.approx(whole, abs=1e-5)
