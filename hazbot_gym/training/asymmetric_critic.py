"""Asymmetric actor-critic: the critic observes the time left, the actor does not.

Policies do not observe the time, yet the return-to-go depends on it: near the horizon, a slow
leader costs the rest of the path. A critic without the time attributes this loss to the robot's
actions. The critic is discarded after training, so it may observe more than the actor (asymmetric
actor-critic, Pinto et al., RSS 2018; time in the critic, Pardo et al., ICML 2018).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor


class TimedCriticPolicy(ActorCriticPolicy):
    """Actor-critic policy with the time left as the last entry, read by the critic alone."""

    def _build_mlp_extractor(self) -> None:
        self.mlp_extractor = _Networks(
            self.features_dim, self.net_arch, self.activation_fn, self.device
        )

    def predict(self, observation: Any, *arguments: Any, **options: Any) -> Any:
        """Return the action; the last entry of observations is optional."""
        assert self.observation_space.shape is not None
        if np.shape(observation)[-1] == self.observation_space.shape[0] - 1:
            observation = np.insert(observation, np.shape(observation)[-1], 0.0, axis=-1)
        return super().predict(observation, *arguments, **options)


class _Networks(MlpExtractor):
    """The hidden layers of both; the actor's ignore the last feature."""

    def __init__(self, width: int, net_arch: Any, activation: Any, device: Any) -> None:
        super().__init__(width, net_arch, activation, device)
        self.policy_net = MlpExtractor(width - 1, net_arch, activation, device).policy_net

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        return super().forward_actor(features[..., :-1])
