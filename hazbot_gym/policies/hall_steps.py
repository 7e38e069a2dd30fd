"""Step function of Hall's zones: each zone of the nearest person has a fixed speed.

One of the paper's five levels for each phase of Hall (1966), from standing in the intimate zone to
nominal speed from the far social phase on. It is the paper's idea without fuzziness, an ablation of
the memberships and patterns of ``fuzzy_expert``. The default zones are wider than Hall's, so that
the robot slows down early. The zones apply to people, not to raw ultrasonic readings, for which the
walls of every corridor are in the personal zone; the sonar tier uses ``sonar_estimate``.
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
    """Drives at the speed of the nearest person's zone."""

    scale: Annotated[float, Ge(0)] = 2.0  # scale of the zones, 1: Hall's; the sweep parameter

    def speed_share(self, observation: Observations) -> Floats:
        """Return one of the five levels; see ``base.Rule``."""
        nearest_m = clearances_m(layout_of(observation).decode(observation)).min(axis=-1)
        share: Floats = SHARES[np.searchsorted(self.scale * BOUNDS_M, nearest_m, side="right")]
        return share
