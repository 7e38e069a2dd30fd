"""PPO on a base: it starts as the base exactly, and what is exported is what was trained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.policies.residual import on_its_base
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.combined_envs import policy_width
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.residual_envs import ResidualEnvs
from hazbot_gym.training.run import train
from hazbot_gym.training.validation import validate
from hazbot_gym.training.vec_envs import make_envs

RUN: dict[str, Any] = {
    "worlds": 8,
    "steps": 512,
    "residual": {"base": "fuzzy_expert", "scale": 0.5},
    "overrides": {"max_episode_steps": 60},
    "options": {"n_steps": 16, "batch_size": 64, "n_epochs": 2},
    "network": {"net_arch": [8]},
    "validation": {"every_steps": 512, "episodes": 4},
}


def run(**changes: Any) -> TrainConfig:
    return load_training(None, **{**RUN, **changes})


@pytest.mark.parametrize("is_timed", [False, True])
def test_without_corrections_the_worlds_are_those_of_the_base(*, is_timed: bool) -> None:
    config, base = run(asymmetric_critic=is_timed), policies.make("fuzzy_expert")
    alone, below = make_envs(config), ResidualEnvs(make_envs(config), config.residual)  # type: ignore[arg-type]
    for envs in (alone, below):
        envs.seed(5)
    seen = alone.reset()
    assert np.array_equal(seen, below.reset())
    for _ in range(150):
        seen, rewards, *_ = alone.step(base.predict(seen[:, : policy_width(alone)])[0])
        also_seen, also_rewards, *_ = below.step(np.zeros((8, 1), np.float32))
        assert np.array_equal(seen, also_seen)
        assert np.array_equal(rewards, also_rewards)


@pytest.mark.parametrize("is_timed", [False, True])
def test_training_begins_exactly_at_the_base(*, is_timed: bool) -> None:
    config = run(asymmetric_critic=is_timed)
    model = make_model(config, make_envs(config))
    new = on_its_base(model, config.residual.model_dump())  # type: ignore[union-attr]
    assert validate(new, config) == validate(policies.make("fuzzy_expert"), config)


@pytest.mark.parametrize("algorithm", ["ppo", "recurrent_ppo"])
def test_what_is_exported_drives_as_what_was_trained(algorithm: str, tmp_path: Path) -> None:
    config = run(algorithm=algorithm, learning_rate=0.03, final_learning_rate=0.03)
    result = train(config, tmp_path / "run")
    layout, rng = LAYOUTS["tracks"], np.random.default_rng(0)
    seen = rng.uniform(layout.low, layout.high, (200, 51)).astype(np.float32)
    trained = on_its_base(result.model, config.residual.model_dump())  # type: ignore[union-attr]
    action, _ = policies.make(f"learned:{result.policy}").predict(seen)
    assert action == pytest.approx(trained.predict(seen)[0], abs=1e-5)
    assert action != pytest.approx(policies.make("fuzzy_expert").predict(seen)[0], abs=0.01)
