"""Vectorized training environments: the engine's worlds under a stack of wrappers.

``CombinedEnvs`` under ``EpisodeMonitor``, ``PricedRewards`` and ``ShapedRewards`` if configured,
``ScaledRewards``, ``TimeLeft`` if the critic observes it, and ``RepeatedActions`` if configured.
The algorithms add ``ResidualEnvs`` and ``PenalizedEnvs``.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.config import Config
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.sb3 import CorridorVecEnv
from hazbot_gym.errors import InvalidInput
from hazbot_gym.training.action_repeat import RepeatedActions
from hazbot_gym.training.asymmetric_critic import TimeLeft
from hazbot_gym.training.combined_envs import CombinedEnvs
from hazbot_gym.training.config import TrainConfig, split
from hazbot_gym.training.episode_monitor import EpisodeMonitor
from hazbot_gym.training.priced_rewards import PricedRewards, price_input_of
from hazbot_gym.training.shaping import ShapedRewards


class ScaledRewards(VecEnvWrapper):
    """Environment wrapper: multiplies rewards by a constant."""

    def __init__(self, envs: VecEnv, scale: float) -> None:
        super().__init__(envs)
        self.scale = scale

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        scaled = np.multiply(rewards, self.scale, dtype=np.float64).astype(np.float32)
        return observations, scaled, dones, infos


def make_envs(config: TrainConfig) -> VecEnvWrapper:
    """Make the environments of a run, with the worlds split among them.

    Raises:
        InvalidInput: An environment cannot be made, or they do not fit each other.
    """
    if config.worlds < len(config.env):
        raise InvalidInput(
            f"worlds: given {config.worlds}, allowed is {len(config.env)} or more, one for each env"
        )
    make = _batched if config.engine == "batched" else _pymunk
    sizes, configs = split(config.worlds, len(config.env)), config.environments()
    if len({each.gas is None for each in configs}) > 1:
        given = ", ".join(config.env)
        raise InvalidInput(f"env: given {given}, allowed are environments all with gas, or none")
    parts = [make(*each, config.threads) for each in zip(configs, sizes, strict=True)]
    envs: VecEnvWrapper = EpisodeMonitor(
        CombinedEnvs(parts, configs, staggered=config.staggered_starts)
    )
    inputs = price_input_of(config)
    if inputs:
        envs = PricedRewards(envs, inputs)
    if config.shaping == "free_drive":
        envs = ShapedRewards(envs)
    envs = ScaledRewards(envs, config.reward_scale)
    if config.asymmetric_critic:
        envs = TimeLeft(envs)
    return RepeatedActions(envs, config.action_repeat) if config.action_repeat > 1 else envs


def require_speeds(envs: VecEnv, key: str) -> None:
    """Reject a config key that requires continuous actions."""
    if hasattr(envs.action_space, "n"):
        raise InvalidInput(f"{key}: given action_type 'discrete', allowed is 'continuous'")


def _batched(config: Config, worlds: int, threads: int) -> VecEnv:
    return CorridorVecEnv(worlds, config=config, threads=threads, has_infos=False)


def _pymunk(config: Config, worlds: int, threads: int) -> VecEnv:
    return DummyVecEnv([partial(CorridorEnv, config)] * worlds)
