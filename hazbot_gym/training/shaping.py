"""What a decision loses against a free drive, instead of what it earns.

Most of a return is the path itself, which every policy that arrives is paid for alike. A critic
must then know the path's worth to a hundredth before it sees what waiting costs; and one that does
not know the time cannot see at all that the arrival term presses. Potential-based shaping (Ng,
Harada and Russell, ICML 1999, with their gamma = 1) takes out of every reward what a free drive
would earn:

    r'(t) = r(t) + Phi(t+1) - Phi(t)
    Phi(t) = w_p n + w_a (1 - (t + n) / H), and 0 after the end

with n the decisions that the rest of the path takes at nominal speed, H the decisions allowed, w_p
and w_a the weights of progress and arrival. What is left of a reward are the penalties and the
delay, w_a (1 - advance) / H. The r' of an episode add up to its return less Phi(0), which no policy
changes. For that to hold, running out of time is an end like any other, and its value is not
bootstrapped: what is left of the path then is lost.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats


class FreeDrive:
    """The return that is still to be had in each of N worlds if nobody is in the way."""

    def __init__(self, configs: Sequence[Config], sizes: Sequence[int]) -> None:
        """Note what each world pays; ``sizes`` says how many there are of each config."""
        self._progress = np.repeat([config.reward.progress for config in configs], sizes)
        self._arrival = np.repeat([config.reward.arrival for config in configs], sizes)
        self._allowed = np.repeat([config.max_episode_steps for config in configs], sizes)

    def time_left(self, steps: Floats) -> Floats:
        """Return the share of the decisions allowed that is left after some (N,)."""
        share: Floats = 1.0 - steps / self._allowed
        return share

    def potential(self, path: Floats, advance: Floats, steps: Floats) -> Floats:
        """Return Phi (N,).

        Args:
            path: (N,) decisions that the whole path takes at nominal speed.
            advance: (N,) sum of the progress terms so far.
            steps: (N,) decisions taken so far.
        """
        left = np.maximum(path - advance, 0.0)
        return self._progress * left + self._arrival * self.time_left(steps + left)
