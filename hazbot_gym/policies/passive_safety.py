"""Passive safety: so slow that the robot stands before anybody can reach it.

Mitsch, Ghorbal, Vogelbacher and Platzer (2017), Formal verification of obstacle avoidance and
navigation of ground robots: a robot at speed v, d away from an obstacle that moves in whatever
direction with at most V, has stopped before they meet if

    d > v^2/(2b) + V v/b + (A/b + 1) (A eps^2/2 + eps (v + V))

with braking b, acceleration A, and a decision every eps. Who walks into a standing robot is not the
robot's fault. Nothing is asked of where people are heading, so nothing is lost if they turn: the
proof holds as long as V does, which is why V is assumed, not measured. A walker's V is enough not
to hit anybody; the default is a runner's, since people want more room than safety asks. Left out:
the proof's uncertainty of position (d is what the tracker says), and the drive's lag behind its
command.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import clearances_m
from hazbot_gym.policies.robot import ACCELERATION_MPS2, BRAKING_MPS2, DECISION_S, NOMINAL_MPS
from hazbot_gym.task.observation import layout_of


@dataclass(frozen=True, config=OPTIONS)
class PassiveSafety(PeopleRule):
    """Drives at the largest speed that is passively safe towards everybody."""

    obstacle_mps: Annotated[float, Ge(0)] = 4.0  # V, the knob of the family
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the share that the nearest person permits; see ``base.Rule``."""
        nearest_m = clearances_m(layout_of(observation).decode(observation)).min(axis=-1)
        return np.clip(safe_speed(nearest_m, self.obstacle_mps) / self.nominal_mps, 0.0, 1.0)


def safe_speed(d: npt.ArrayLike, V: float) -> Floats:
    """Return the largest v that is passively safe at clearances d [m], 0 where none is.

    ``v = -B + sqrt(B^2 + 2b (d - (A/b + 1) (A eps^2/2 + eps V)))`` with ``B = V + (A + b) eps``.
    """
    A, b, eps = ACCELERATION_MPS2, BRAKING_MPS2, DECISION_S
    B = V + (A + b) * eps
    spare_m = np.asarray(d) - (A / b + 1.0) * (A * eps**2 / 2.0 + eps * V)
    return np.sqrt(B**2 + 2.0 * b * np.maximum(spare_m, 0.0)) - B
