"""The intelligent driver model: follows whoever is ahead like a car in a lane.

Treiber, Hennecke and Helbing (2000), Congested traffic states in empirical observations and
microscopic simulations:

    dv/dt = a [1 - (v/v0)^4 - (s*/s)^2],  s* = s0 + v T + v dv/(2 sqrt(a b))

with the gap s to the one ahead, dv the speed at which it closes, and the robot's own limits as a
and b. Every person who is in the robot's lane, or will step into it soon, is one ahead, with the
gap to where that happens; the strictest counts. v is the speed commanded last, so that the model
drives on where the drive still lags behind.

The default lane is as wide as the corridor, and the headway longer than any driver's: the robot is
slow, and people want room. Left out: people beside the lane and behind, whatever their personal
space; and that people, other than cars, step aside. It is made for those who walk ahead.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.proxemics import INTIMATE_M
from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import RADII_M, People, people_seen
from hazbot_gym.policies.robot import ACCELERATION_MPS2, BRAKING_MPS2, DECISION_S, NOMINAL_MPS
from hazbot_gym.task.observation import layout_of

SOON_S = 3.0  # who steps into the lane later does not count yet
TOUCHING_M = 0.01  # smaller gaps count as this


@dataclass(frozen=True, config=OPTIONS)
class Idm(PeopleRule):
    """Keeps a minimum gap and a time headway to everybody in its lane."""

    headway_s: Annotated[float, Ge(0)] = 6.0  # T, the knob of the family
    lane_m: Annotated[float, Gt(0)] = 1.2  # from the way to the lane's edge, for centres
    gap_m: Annotated[float, Ge(0)] = INTIMATE_M  # s0
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # v0, speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the share of the last command plus ``a dt``; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        people, v, v0 = people_seen(seen), seen["command_mps"], self.nominal_mps
        pressure = self._pressure(people, v[..., None]).max(axis=-1)
        change_mps = ACCELERATION_MPS2 * (1.0 - (v / v0) ** 4 - pressure) * DECISION_S
        share: Floats = np.clip((v + change_mps) / v0, 0.0, 1.0)
        return share

    def _pressure(self, people: People, v: Floats) -> Floats:
        """Return (s*/s)^2 for everybody, 0 who is not ahead: (..., P)."""
        enters_s = _enters_s(people, self.lane_m)
        is_ahead = people.x_m + (people.vx_mps - v) * enters_s > 0.0
        s = np.maximum(people.x_m + people.vx_mps * enters_s - RADII_M, TOUCHING_M)
        dv = v - people.vx_mps
        closing_m = v * dv / (2.0 * math.sqrt(ACCELERATION_MPS2 * BRAKING_MPS2))
        wanted_m = np.maximum(self.gap_m + v * self.headway_s + closing_m, 0.0)  # s*
        counts = people.is_there & is_ahead & (enters_s <= SOON_S)
        return np.where(counts, (wanted_m / s) ** 2, 0.0)


def _enters_s(people: People, lane_m: float) -> Floats:
    """Return when everybody steps into the lane, 0 who is in it, a long time who stays beside."""
    inward_mps = np.maximum(-people.vy_mps * np.sign(people.y_m), 1e-6)
    return np.maximum(np.abs(people.y_m) - lane_m, 0.0) / inward_mps
