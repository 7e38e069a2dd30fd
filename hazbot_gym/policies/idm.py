"""Intelligent driver model (IDM): car following behind people ahead.

Treiber, Hennecke and Helbing (2000), Congested traffic states in empirical observations and
microscopic simulations:

    dv/dt = a [1 - (v/v0)^4 - (s*/s)^2],  s* = s0 + v T + v dv/(2 sqrt(a b))

with the gap s to the leader, its closing speed dv, and the robot's limits as a and b. Every person
in the robot's lane is a leader; so is a person about to enter the lane, with the gap to the point
of entry. The most restrictive leader counts. v is the last command, without the drive's lag.

The default lane is as wide as the corridor, and the headway longer than in traffic: the robot is
slow, and people want space. Not modeled: people beside the lane or behind the robot, and people who
give way. The model is meant for leading people.
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

SOON_S = 3.0  # later entries into the lane are ignored
TOUCHING_M = 0.01  # lower bound of gaps


@dataclass(frozen=True, config=OPTIONS)
class Idm(PeopleRule):
    """Keeps a minimum gap and a time headway to all people in its lane."""

    headway_s: Annotated[float, Ge(0)] = 6.0  # T, the sweep parameter
    lane_m: Annotated[float, Gt(0)] = 1.2  # half width of the lane, for centres
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
        """Return (s*/s)^2 for each person, 0 if not ahead: (..., P)."""
        enters_s = _enters_s(people, self.lane_m)
        is_ahead = people.x_m + (people.vx_mps - v) * enters_s > 0.0
        s = np.maximum(people.x_m + people.vx_mps * enters_s - RADII_M, TOUCHING_M)
        dv = v - people.vx_mps
        closing_m = v * dv / (2.0 * math.sqrt(ACCELERATION_MPS2 * BRAKING_MPS2))
        wanted_m = np.maximum(self.gap_m + v * self.headway_s + closing_m, 0.0)  # s*
        counts = people.is_there & is_ahead & (enters_s <= SOON_S)
        return np.where(counts, (wanted_m / s) ** 2, 0.0)


def _enters_s(people: People, lane_m: float) -> Floats:
    """Return each person's time of entry into the lane, 0 if inside, large if never."""
    inward_mps = np.maximum(-people.vy_mps * np.sign(people.y_m), 1e-6)
    return np.maximum(np.abs(people.y_m) - lane_m, 0.0) / inward_mps
