"""Stop when near: a constant speed with a protective stop.

The robot stops while a person is near; bearing and motion are ignored. This policy is a common
baseline of social navigation studies, and the simplest one without contacts.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import clearances_m
from hazbot_gym.task.observation import layout_of


@dataclass(frozen=True, config=OPTIONS)
class StopWhenNear(PeopleRule):
    """Stops while the clearance to the nearest person is below a threshold."""

    stop_m: Annotated[float, Ge(0)] = 1.2  # the sweep parameter; Hall's personal distance
    fraction: Annotated[float, Gt(0), Le(1)] = 1.0  # of the nominal speed, while no person is near

    def speed_share(self, observation: Observations) -> Floats:
        """Return 0 or the fraction; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        return np.where((clearances_m(seen) < self.stop_m).any(axis=-1), 0.0, self.fraction)
