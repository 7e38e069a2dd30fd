"""Action repeat: in training, each action of the policy holds for several decisions.

Commands differ in their effect only over about a second: the drive accelerates slowly, and people
react late. Noise that is drawn anew ten times a second averages out before it has an effect; that
of an action that holds does not, and an update covers more time (Mnih et al., Nature 2015).
Validation and use are unaffected: the policy acts at every decision there.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.envs.arguments import Info


class RepeatedActions(VecEnvWrapper):
    """Environment wrapper: takes several decisions with each action, and sums their rewards.

    If an episode ends on the way, the action holds for the first decisions of the next episode too;
    their rewards are added to the next step's.
    """

    def __init__(self, envs: VecEnv, repeat: int) -> None:
        super().__init__(envs)
        self.repeat = repeat
        self._early = np.zeros(envs.num_envs, np.float32)  # rewards of episodes just begun

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        self._early[:] = 0.0
        return self.venv.reset()

    def step_async(self, actions: npt.NDArray[np.generic]) -> None:
        """Store the actions."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Take ``repeat`` decisions in every world."""
        ended = np.zeros(self.num_envs, np.bool_)
        rewards, self._early = self._early, np.zeros_like(self._early)
        last: list[Info] = [{}] * self.num_envs
        for _ in range(self.repeat):
            observations, new, dones, infos = self.venv.step(self._actions)
            rewards += np.where(ended, 0.0, new)
            self._early += np.where(ended, new, 0.0)
            for i in np.flatnonzero(dones).tolist():
                last[i] = infos[i]
            ended |= dones
        return observations, rewards, ended, last
