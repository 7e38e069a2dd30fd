"""Potential-based reward shaping: each reward minus that of a free drive.

Most of a return is progress along the path, equal for every policy that arrives. A critic must then
predict this part to 1 % before it can resolve the cost of waiting, and without the time it cannot
predict the arrival term at all. Potential-based shaping (Ng, Harada and Russell, ICML 1999, with
their gamma = 1) subtracts the reward of a free drive:

    r'(t) = r(t) + Phi(t+1) - Phi(t)
    Phi(t) = w_p n + w_a (1 - (t + n) / H), and 0 after the end

with n the remaining decisions at nominal speed, H the horizon in decisions, w_p and w_a the weights
of progress and arrival. The remaining reward consists of the penalties and the delay, w_a
(1 - advance) / H. The r' of an episode sum to its return minus Phi(0), a constant. For this to
hold, a timeout is a termination, and its value is not bootstrapped: the rest of the path is lost.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats


class FreeDrive:
    """Return-to-go Phi of a free drive in each of N worlds."""

    def __init__(self, configs: Sequence[Config], sizes: Sequence[int]) -> None:
        """Store the reward weights of each world; ``sizes`` are the worlds per config."""
        self._progress = np.repeat([config.reward.progress for config in configs], sizes)
        self._arrival = np.repeat([config.reward.arrival for config in configs], sizes)
        self._allowed = np.repeat([config.max_episode_steps for config in configs], sizes)

    def time_left(self, steps: Floats) -> Floats:
        """Return the remaining share of the horizon (N,)."""
        share: Floats = 1.0 - steps / self._allowed
        return share

    def potential(self, path: Floats, advance: Floats, steps: Floats) -> Floats:
        """Return Phi (N,).

        Args:
            path: (N,) decisions for the whole path at nominal speed.
            advance: (N,) sum of the progress terms so far.
            steps: (N,) decisions taken so far.
        """
        left = np.maximum(path - advance, 0.0)
        return self._progress * left + self._arrival * self.time_left(steps + left)
