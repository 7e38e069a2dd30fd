"""Asymmetric actor-critic: the critic observes the time left, the actor does not.

Policies do not observe the time, yet the return-to-go depends on it: near the horizon, a slow
leader costs the rest of the path. A critic without the time attributes this loss to the robot's
actions. The critic is discarded after training, so it may observe more than the actor (asymmetric
actor-critic, Pinto et al., RSS 2018; time in the critic, Pardo et al., ICML 2018).
"""

from __future__ import annotations

from typing import cast

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.policies.guard import Observations
from hazbot_gym.training.combined_envs import CombinedEnvs, aligned


class TimeLeft(VecEnvWrapper):
    """Environment wrapper: observations end with the share of the horizon that is left."""

    def __init__(self, envs: VecEnv) -> None:
        """Wrap environments above a ``CombinedEnvs``."""
        space = envs.observation_space
        assert isinstance(space, gymnasium.spaces.Box)
        low, high = np.append(space.low, np.float32(0.0)), np.append(space.high, np.float32(1.0))
        super().__init__(envs, gymnasium.spaces.Box(low, high))
        self._envs = cast(CombinedEnvs, envs.unwrapped)
        self._horizon = self._envs.of_each_world(lambda config: config.max_episode_steps)

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        return self._with_time(cast(Observations, self.venv.reset()))

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for i in np.flatnonzero(dones):
            last = infos[i]["terminal_observation"]
            infos[i]["terminal_observation"] = np.append(last, np.float32(0.0))
        return self._with_time(cast(Observations, observations)), rewards, dones, infos

    def _with_time(self, observations: Observations) -> Observations:
        width = observations.shape[1]
        timed = aligned(self.num_envs, width + 1)
        timed[:, :width] = observations
        timed[:, width] = 1.0 - self._envs.steps / self._horizon
        return timed


class AsymmetricCriticPolicy(ActorCriticPolicy):
    """Actor-critic policy with the time left as the last entry, read by the critic alone."""

    def _build_mlp_extractor(self) -> None:
        self.mlp_extractor = _Networks(
            self.features_dim, self.net_arch, self.activation_fn, self.device
        )

    def predict(
        self,
        observation: npt.NDArray[np.generic] | dict[str, npt.NDArray[np.generic]],
        state: tuple[npt.NDArray[np.generic], ...] | None = None,
        episode_start: npt.NDArray[np.generic] | None = None,
        deterministic: bool = False,
    ) -> tuple[npt.NDArray[np.generic], tuple[npt.NDArray[np.generic], ...] | None]:
        """Return the action; the last entry of observations is optional."""
        assert self.observation_space.shape is not None
        seen = cast(Observations, observation)
        if np.shape(seen)[-1] == self.observation_space.shape[0] - 1:
            observation = np.insert(seen, np.shape(seen)[-1], 0.0, axis=-1)
        return super().predict(observation, state, episode_start, deterministic)


class _Networks(MlpExtractor):
    """Hidden layers of actor and critic; the actor ignores the last feature."""

    def __init__(
        self,
        width: int,
        net_arch: list[int] | dict[str, list[int]],
        activation: type[torch.nn.Module],
        device: torch.device | str,
    ) -> None:
        super().__init__(width, net_arch, activation, device)
        self.policy_net = MlpExtractor(width - 1, net_arch, activation, device).policy_net

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        return super().forward_actor(features[..., :-1])
