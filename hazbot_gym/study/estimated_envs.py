"""Worlds of the sonar tier in which networks see the people that the readings betray."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnvWrapper

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.people_rule import SONAR, TRACKS, with_estimates
from hazbot_gym.policies.sonar_estimate import Echoes
from hazbot_gym.study.training_envs import TrainingEnvs, aligned, with_time


class EstimatedEnvs(VecEnvWrapper):
    """Observations as of the tracks tier, of estimates; the time left stays where there is one."""

    def __init__(self, envs: TrainingEnvs) -> None:
        """Put estimates into what some environments show.

        Raises:
            InvalidInput: They are of another tier, on which people are tracked.
        """
        if envs.width != SONAR.width:
            raise InvalidInput("estimated: given with tracked people, allowed is the tier 'sonar'")
        space = gymnasium.spaces.Box(TRACKS.low, TRACKS.high)
        super().__init__(envs, with_time(space) if envs.is_timed else space)
        self.width = TRACKS.width
        self._echoes: Echoes | None = None

    def reset(self) -> npt.NDArray[np.float32]:
        """Start new episodes everywhere."""
        observations = self.venv.reset()
        assert isinstance(observations, np.ndarray)
        full, self._echoes = _estimated(observations, None)
        return full

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Take one decision in every world."""
        observations, rewards, dones, infos = self.venv.step_wait()
        assert isinstance(observations, np.ndarray)
        self._estimate_ends(np.flatnonzero(dones), infos)
        full, self._echoes = _estimated(observations, self._echoes, dones)
        return full, rewards, dones, infos

    def _estimate_ends(self, ended: npt.NDArray[np.intp], infos: list[dict[str, Any]]) -> None:
        """Put estimates into the last observations of episodes that have ended."""
        if not len(ended):
            return
        assert self._echoes is not None
        last = np.stack([infos[i]["terminal_observation"] for i in ended])
        full, _ = _estimated(last, Echoes(*(values[ended] for values in self._echoes)))
        for i, observation in zip(ended, full, strict=True):
            infos[i]["terminal_observation"] = observation


def _estimated(
    observations: npt.NDArray[np.float32],
    echoes: Echoes | None,
    starts: npt.NDArray[np.bool_] | None = None,
) -> tuple[npt.NDArray[np.float32], Echoes]:
    """Return observations (N, 12 or 13) with estimated people, (N, 48 or 49), and the echoes."""
    own, time_left = observations[:, : SONAR.width], observations[:, SONAR.width :]
    people, echoes = with_estimates(own, echoes, starts)
    full = aligned(len(own), TRACKS.width + time_left.shape[1])
    np.concatenate([people, time_left], axis=1, out=full)
    return full, echoes
