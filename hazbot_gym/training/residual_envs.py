"""Environments of residual policy learning: learned corrections of a base policy's actions."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.residual import base_of, corrected
from hazbot_gym.training.combined_envs import driver_in, policy_width
from hazbot_gym.training.config import Residual
from hazbot_gym.training.vec_envs import require_speeds


class ResidualEnvs(VecEnvWrapper):
    """Environment wrapper: actions are corrections in [-1, 1], added to the base's actions."""

    def __init__(self, envs: VecEnv, residual: Residual) -> None:
        """Wrap environments with a base policy.

        Raises:
            InvalidInput: The base is unknown, cannot act on these observations, or actions are
                discrete and cannot be corrected.
        """
        require_speeds(envs, "residual")
        super().__init__(envs)
        self.base = driver_in(envs, base_of(residual.base), residual.base)
        self.correction_scale = residual.scale
        self._width = policy_width(envs)
        self._begin(np.zeros((envs.num_envs, self._width), np.float32))
        self._act()

    def reset(self) -> npt.NDArray[np.float32]:
        """Start new episodes everywhere."""
        observations = self.venv.reset()
        assert isinstance(observations, np.ndarray)
        self._begin(observations)
        return observations

    def step_async(self, actions: npt.NDArray[Any]) -> None:
        """Send the corrected actions."""
        self.venv.step_async(corrected(self._act(), actions, self.correction_scale))

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, self._starts, infos = self.venv.step_wait()
        self._seen = cast(Observations, observations)
        return self._seen, rewards, self._starts, infos

    def _begin(self, observations: npt.NDArray[np.float32]) -> None:
        self._seen, self._state = observations, None
        self._starts = np.ones(len(observations), np.bool_)

    def _act(self) -> npt.NDArray[np.float32]:
        """Return the base's action on the current observations."""
        seen = self._seen[:, : self._width]
        action, self._state = self.base.predict(seen, self._state, self._starts)
        return action
