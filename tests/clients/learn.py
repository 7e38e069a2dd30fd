"""A moment of learning with algorithms that have the interface of Stable-Baselines3."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from hazbot_gym.envs.sb3 import CorridorVecEnv

DISCRETE = ("DQN", "QRDQN", "MaskablePPO")
OPTIONS: dict[str, dict[str, Any]] = {
    "ARS": {"n_delta": 2},
    "A2C": {},
    "PPO": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "MaskablePPO": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "RecurrentPPO": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "TRPO": {"n_steps": 16, "batch_size": 32},
}
OFF_POLICY = {"buffer_size": 1000, "learning_starts": 16, "batch_size": 16}


def algorithms(library: ModuleType) -> list[Any]:
    """Return the algorithms that a library exports."""
    exported = [getattr(library, name) for name in library.__all__]
    return [each for each in exported if isinstance(each, type) and issubclass(each, BaseAlgorithm)]


def learn_and_act(algorithm: Any) -> None:
    """Learn for 128 decisions on the batched engine; the action is one of the environment's."""
    name = algorithm.__name__
    action_type = "discrete" if name in DISCRETE else "continuous"
    envs = CorridorVecEnv(2, seed=0, action_type=action_type, max_episode_steps=30)
    policy = "MlpLstmPolicy" if name == "RecurrentPPO" else "MlpPolicy"
    model = algorithm(policy, envs, seed=0, device="cpu", **OPTIONS.get(name, OFF_POLICY))
    model.learn(128, **({"use_masking": False} if name == "MaskablePPO" else {}))
    assert model.num_timesteps >= 128
    actions, _ = model.predict(envs.reset(), deterministic=True)
    assert len(actions) == 2
    assert all(envs.action_space.contains(np.asarray(action)) for action in actions)
