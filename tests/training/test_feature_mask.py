"""Masked features move no network, in training or exported, and the base sees it all the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hazbot_gym import policies
from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.config import TrainConfig, hidden_entries, load_training
from hazbot_gym.training.run import train
from hazbot_gym.training.vec_envs import make_envs

HIDDEN = ("range_*", "person*_closest_m")
ENTRIES = [0, 1, 2, 3, 20, 33, 46]


def config(**changes: Any) -> TrainConfig:
    values: dict[str, Any] = {"worlds": 3, "hidden": HIDDEN, "network": {"net_arch": [8]}}
    return load_training(None, **{**values, **changes})


def test_fields_are_found_by_their_names() -> None:
    tracks = LAYOUTS["tracks"]
    assert hidden_entries(HIDDEN, tracks) == ENTRIES
    assert {tracks.names[i] for i in ENTRIES[4:]} == {f"person{i}_closest_m" for i in range(3)}
    assert hidden_entries(HIDDEN, LAYOUTS["sonar"]) == [0, 1, 2, 3]


@pytest.mark.parametrize(
    "changes",
    [
        {"algorithm": "ppo"},
        {"algorithm": "ppo", "asymmetric_critic": True},
        {"algorithm": "recurrent_ppo"},
        {"algorithm": "sac", "options": {"buffer_size": 10}},
        {"algorithm": "td3", "options": {"buffer_size": 10}},
    ],
)
def test_hidden_entries_move_neither_the_model_nor_its_export(changes: dict[str, Any]) -> None:
    model = make_model(config(**changes), make_envs(config(**changes)))
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.mul_(3.0)
    layout, rng = LAYOUTS["tracks"], np.random.default_rng(0)
    observations = rng.uniform(layout.low, layout.high, (100, layout.width)).astype(np.float32)
    moved, others = observations.copy(), observations.copy()
    moved[:, ENTRIES] = rng.permutation(observations[:, ENTRIES])
    others[:, 4] = rng.permutation(observations[:, 4])  # speed, which is seen
    actor = actor_of(model)
    for act in (lambda o: model.predict(o, deterministic=True)[0], lambda o: actor.act(o)[0]):
        assert np.array_equal(act(observations), act(moved))
        assert not np.array_equal(act(observations), act(others))
    expected, _ = model.predict(observations, deterministic=True)
    assert actor.act(observations)[0] == pytest.approx(expected, abs=1e-4)


def test_the_base_of_a_residual_sees_everything(tmp_path: Path) -> None:
    run = config(
        hidden=["*"],
        residual={"base": "ssm:mode=strict", "scale": 0.5},
        steps=96,
        options={"n_steps": 16, "batch_size": 48},
        overrides={"max_episode_steps": 20},
        validation={"every_steps": 96, "episodes": 2},
    )
    policy = policies.make(f"learned:{train(run, tmp_path).policy}")
    layout, rng = LAYOUTS["tracks"], np.random.default_rng(0)
    observations = rng.uniform(layout.low, layout.high, (100, layout.width)).astype(np.float32)
    actions, base = policy.predict(observations)[0], policies.make("ssm:mode=strict")
    inside = np.abs(actions) < 1.0
    corrections = (actions - base.predict(observations)[0])[inside]
    assert np.ptp(corrections) < 1e-6  # a network that sees nothing answers the same to all
    assert len(corrections) > 5
