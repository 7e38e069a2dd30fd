"""Worlds in which networks see estimated people: what is shown, and what is exported from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.learned import driver
from hazbot_gym.policies.people_rule import with_estimates
from hazbot_gym.study.estimated_envs import EstimatedEnvs
from hazbot_gym.study.train_config import TrainConfig, load_training
from hazbot_gym.study.training import train
from hazbot_gym.study.training_envs import make_envs
from hazbot_gym.study.validation import validate

RUN: dict[str, Any] = {
    "worlds": 8,
    "steps": 512,
    "estimated": True,
    "overrides": {"max_episode_steps": 60, "tier": "sonar"},
    "options": {"n_steps": 16, "batch_size": 64, "n_epochs": 2},
    "network": {"net_arch": [8]},
    "validation": {"every_steps": 512, "episodes": 4},
}


def run(**changes: Any) -> TrainConfig:
    return load_training(None, **{**RUN, **changes})


@pytest.mark.parametrize("is_timed", [False, True])
def test_what_is_shown_are_the_readings_and_the_people_they_betray(*, is_timed: bool) -> None:
    bare, estimated = (
        make_envs(run(timed_critic=is_timed)),
        EstimatedEnvs(make_envs(run(timed_critic=is_timed))),
    )
    for envs in (bare, estimated):
        envs.seed(5)
    echoes, starts, ends = None, None, 0
    seen, shown = bare.reset(), estimated.reset()
    for _ in range(130):
        full, echoes = with_estimates(seen[:, :12], echoes, starts)
        assert np.array_equal(shown[:, :48], full)
        assert np.array_equal(shown[:, 48:], seen[:, 12:])
        actions = np.ones((8, 1), np.float32)
        seen, _, starts, infos = bare.step(actions)
        shown, _, _, others = estimated.step(actions)
        for i in np.flatnonzero(starts):
            last, other = (each[i]["terminal_observation"] for each in (infos, others))
            kept = type(echoes)(*(values[i : i + 1] for values in echoes))
            assert np.array_equal(other[:48], with_estimates(last[None, :12], kept)[0][0])
            assert np.array_equal(other[48:], last[12:])
            ends += 1
    assert ends >= 16


@pytest.mark.parametrize("residual", [None, {"base": "ssm:mode=strict", "scale": 0.5}])
def test_what_is_exported_drives_as_what_was_trained(residual: Any, tmp_path: Path) -> None:
    config = run(residual=residual, learning_rate=0.03, final_learning_rate=0.03)
    result = train(config, tmp_path)
    trained = driver(result.model, {"estimated": True, "residual": residual})
    exported = policies.make(f"learned:{result.policy}")
    assert validate(trained, config) == pytest.approx(validate(exported, config), rel=1e-4)


def test_tracked_people_need_no_estimate() -> None:
    with pytest.raises(InvalidInput, match="^estimated: given with tracked people, allowed is"):
        EstimatedEnvs(make_envs(run(overrides={})))
