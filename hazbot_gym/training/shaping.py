"""Potential-based reward shaping: each reward minus that of a free drive.

Most of a return is progress along the path, equal for every policy that arrives. A critic must then
predict this part to 1 % before it can resolve the cost of waiting, and without the time it cannot
predict the arrival term at all. Potential-based shaping (Ng, Harada and Russell, ICML 1999, with
their gamma = 1) subtracts the reward of a free drive:

    r'(t) = r(t) + Phi(t+1) - Phi(t)
    Phi(t) = w_p n + w_a (H - t - n) dt, and 0 after the end

with n the remaining decisions at nominal speed, H the horizon in decisions, dt the time of one, w_p
and w_a the weights of progress and arrival. The remaining reward consists of the penalties and the
delay, w_a (1 - advance) dt. The r' of an episode sum to its return minus Phi(0), a constant. For
this to hold, a timeout is a termination, and its value is not bootstrapped: the rest of the path is
lost.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.core.state import Floats
from hazbot_gym.training.combined_envs import CombinedEnvs


class ShapedRewards(VecEnvWrapper):
    """Environment wrapper: adds the change of the potential Phi to each reward."""

    def __init__(self, envs: VecEnv) -> None:
        """Wrap environments above a ``CombinedEnvs``, with unscaled rewards."""
        super().__init__(envs)
        self._envs = cast(CombinedEnvs, envs.unwrapped)
        self._progress = self._envs.of_each_world(lambda config: config.reward.progress)
        self._arrival = self._envs.of_each_world(lambda config: config.reward.arrival)
        self._horizon = self._envs.of_each_world(lambda config: config.max_episode_steps)
        self._decision_s = self._envs.of_each_world(lambda config: config.clock.decision_s)

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        observations = self.venv.reset()
        self._potential = self.potential()
        return observations

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        for i in np.flatnonzero(dones):
            infos[i]["TimeLimit.truncated"] = False  # already part of the potential
        before, self._potential = self._potential, self.potential()
        shaped = rewards + np.where(dones, 0.0, self._potential) - before
        return observations, shaped, dones, infos

    def potential(self) -> Floats:
        """Return Phi (N,) of the running episodes."""
        envs = self._envs
        left = np.maximum(envs.times_free_s / self._decision_s - envs.advance, 0.0)
        time_left_s = (self._horizon - envs.steps - left) * self._decision_s
        found: Floats = self._progress * left + self._arrival * time_left_s
        return found
