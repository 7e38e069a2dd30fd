"""Passive safety: the robot stops before any person can reach it.

Mitsch, Ghorbal, Vogelbacher and Platzer (2017), Formal verification of obstacle avoidance and
navigation of ground robots: a robot at speed v, at distance d from an obstacle with speed at most V
in any direction, has stopped before they meet if

    d > v^2/(2b) + V v/b + (A/b + 1) (A eps^2/2 + eps (v + V))

with braking b, acceleration A, and decision period eps. A standing robot does not count as the
cause of a contact. The bound does not depend on people's headings: the proof holds for any motion
with speed at most V, so V is assumed, not measured. A walking speed for V suffices to avoid
collisions. The default is a running speed, since people want more space than safety requires. Not
modeled: the uncertainty of position in the proof (d is the tracked distance), and the drive's lag.
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
    """Drives at the largest speed that is passively safe for all people."""

    obstacle_mps: Annotated[float, Ge(0)] = 4.0  # V, the sweep parameter
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the share permitted by the nearest person; see ``base.Rule``."""
        nearest_m = clearances_m(layout_of(observation).decode(observation)).min(axis=-1)
        return np.clip(safe_speed(nearest_m, self.obstacle_mps) / self.nominal_mps, 0.0, 1.0)


def safe_speed(d: npt.ArrayLike, V: float) -> Floats:
    """Return the largest v that is passively safe at clearances d [m], 0 if none is.

    ``v = -B + sqrt(B^2 + 2b (d - (A/b + 1) (A eps^2/2 + eps V)))`` with ``B = V + (A + b) eps``.
    """
    A, b, eps = ACCELERATION_MPS2, BRAKING_MPS2, DECISION_S
    B = V + (A + b) * eps
    spare_m = np.asarray(d) - (A / b + 1.0) * (A * eps**2 / 2.0 + eps * V)
    return np.sqrt(B**2 + 2.0 * b * np.maximum(spare_m, 0.0)) - B
