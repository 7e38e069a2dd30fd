"""Hall's zones as steps: in the zone of the nearest person, that zone's speed.

One of the paper's five levels for each phase of Hall (1966), from standing in the intimate zone to
nominal speed from the far social phase on. It is the paper's idea without the fuzziness: what the
memberships and patterns of ``fuzzy_expert`` are worth shows beside it. Wider zones than Hall's slow
the robot before anybody is near, which is why they are the default. The zones are of people. Of
bare ultrasonic readings they would make a crawl of every corridor, whose walls stay in the personal
zone; so on the sonar tier too it is the people of ``sonar_estimate`` who count.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge
from pydantic.dataclasses import dataclass

from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, PERSONAL_NEAR_M, SOCIAL_NEAR_M
from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import clearances_m
from hazbot_gym.task.observation import layout_of

BOUNDS_M = np.array([INTIMATE_M, PERSONAL_NEAR_M, PERSONAL_M, SOCIAL_NEAR_M])
SHARES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # within each bound, and beyond the last


@dataclass(frozen=True, config=OPTIONS)
class HallSteps(PeopleRule):
    """Drives at the speed of the zone in which the nearest person is."""

    scale: Annotated[float, Ge(0)] = 2.0  # of the zones, 1 as Hall has them; the knob of the family

    def speed_share(self, observation: Observations) -> Floats:
        """Return one of the five levels; see ``base.Rule``."""
        nearest_m = clearances_m(layout_of(observation).decode(observation)).min(axis=-1)
        share: Floats = SHARES[np.searchsorted(self.scale * BOUNDS_M, nearest_m, side="right")]
        return share
