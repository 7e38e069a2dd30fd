"""Monitor of the episodes of a run, with sums that are neither scaled nor shaped.

As in Stable-Baselines3's Monitor, the last info of every episode holds under ``episode`` its return
``r`` and length ``l``; here also the sum of each reward term, the cost, the time ratio and the mean
speed. Episodes with a staggered start are left out.
"""

from __future__ import annotations

import numpy as np
from stable_baselines3.common.vec_env import VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from hazbot_gym.training.combined_envs import PROGRESS, CombinedEnvs


class EpisodeMonitor(VecEnvWrapper):
    """Adds the sums of each ended episode to its last info."""

    def __init__(self, envs: CombinedEnvs) -> None:
        super().__init__(envs)
        self._envs = envs
        self._names = (*envs.term_names, "cost", "r", "l")
        self._sums = np.zeros((envs.num_envs, len(self._names)))
        self._decision_s = envs.of_each_world(lambda config: config.clock.decision_s)
        self._nominal_mps = envs.of_each_world(lambda config: config.drive.nominal_speed_mps)

    def reset(self) -> VecEnvObs:
        """Start new episodes everywhere."""
        observations = self.venv.reset()
        self._sums[:] = 0.0
        self._free_s = self._envs.times_free_s.copy()
        self._is_whole = self._envs.steps == 0.0
        return observations

    def step_wait(self) -> VecEnvStepReturn:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        self._sums[:, :-3] += self._envs.terms
        self._sums[:, -3] += self._envs.costs
        self._sums[:, -2] += rewards
        self._sums[:, -1] += 1.0
        for i in np.flatnonzero(dones).tolist():
            sums = self._close(i)
            if self._is_whole[i]:
                infos[i]["episode"] = sums
            self._is_whole[i] = True
        return observations, rewards, dones, infos

    def _close(self, i: int) -> dict[str, float]:
        """Return the sums of the ended episode in world i, and reset them."""
        sums = dict(zip(self._names, self._sums[i].tolist(), strict=True))
        length = self._sums[i, -1]
        sums["time_ratio"] = float(length * self._decision_s[i] / self._free_s[i])
        sums["speed_mps"] = float(self._sums[i, PROGRESS] / length * self._nominal_mps[i])
        self._sums[i] = 0.0
        self._free_s[i] = self._envs.times_free_s[i]
        return sums
