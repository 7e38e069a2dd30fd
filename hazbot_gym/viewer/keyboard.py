"""A person at the window's keyboard as a policy: the arrow keys change the speed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.task.action import speed_action

KEYBOARD = "keyboard"  # its name on the command line
STEP = 0.1  # of the nominal speed, with each press
CHANGES = {"up": STEP, "down": -STEP}


class Keyboard:
    """Policy that commands what was last chosen by key.

    Attributes:
        share: Share of the nominal speed, in [0, 1].
    """

    share = 0.0

    def press(self, key: str) -> None:
        """Take a key; all others than the arrows up and down are left to the window."""
        share = self.share + CHANGES.get(key, 0.0)
        self.share = round(min(max(share, 0.0), 1.0), 6)

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the chosen speed; it is 0 when an episode starts."""
        if episode_start is not None and episode_start.any():
            self.share = 0.0
        return speed_action(self.share), state
