"""A policy for tracked people, driven by those that four ultrasonic sensors betray.

Rules see them by themselves (``people_rule``). A network does where it was trained so: an estimate
made of all readings so far is a memory that need not be learned.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import Actions, Observations, Policy
from hazbot_gym.policies.people_rule import SONAR, with_estimates
from hazbot_gym.task.observation import layout_of


class Estimated:
    """A policy on estimates; the inner state is what is known of the echoes, and its own."""

    def __init__(self, policy: Policy) -> None:
        self.policy = policy

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the action and the next states; see ``Policy.predict``.

        Raises:
            InvalidInput: The observation is not of the sonar tier.
        """
        layout = layout_of(observation)
        if layout.width != SONAR.width:
            raise InvalidInput(
                f"tier: given observations of {layout.width} entries, this policy was trained on "
                f"tier {SONAR.tier} with {SONAR.width}"
            )
        echoes, own = (None, None) if state is None else state
        full, echoes = with_estimates(observation, echoes, episode_start)
        action, own = self.policy.predict(full, own, episode_start, deterministic)
        return action, (echoes, own)
