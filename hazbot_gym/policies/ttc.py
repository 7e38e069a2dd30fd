"""Time-to-collision (TTC) governor: the largest speed without a near collision.

The policy selects the largest speed of a grid at which the time to collision with every observed
person exceeds a horizon, at constant velocities. If there is no such speed, the robot stops. In one
dimension this equals a velocity obstacle with a time limit (Fiorini and Shiller 1998, who leave out
collisions later than a horizon). Bodies are enlarged by a margin. Without a margin, the horizon
changes the braking distance, but hardly any passing distance. Formula and source: ``core/ttc.py``.

On the sonar tier people are assumed to walk along the line of sight (``sonar_estimate``), so the
robot also stops for passing people, and does not stop for people in a blind sector.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.proxemics import INTIMATE_M
from hazbot_gym.core.state import Floats
from hazbot_gym.core.ttc import time_to_collision
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import RADII_M, People, people_seen
from hazbot_gym.policies.robot import NOMINAL_MPS
from hazbot_gym.task.observation import layout_of

SHARES = np.array([1.0, 0.75, 0.5, 0.25, 0.0])  # of the nominal speed: the paper's levels


@dataclass(frozen=True, config=OPTIONS)
class Ttc(PeopleRule):
    """Drives at the largest speed that leads to no collision within a horizon."""

    horizon_s: Annotated[float, Ge(0)] = 2.0  # the sweep parameter
    margin_m: Annotated[float, Ge(0)] = INTIMATE_M  # added to the radii, as C is in ``core/ssm.py``
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the largest share without a near collision; see ``base.Rule``."""
        people = people_seen(layout_of(observation).decode(observation))
        speeds_mps = SHARES * self.nominal_mps
        is_free = is_collision_free(people, speeds_mps, self.horizon_s, self.margin_m)
        return largest_free(SHARES, is_free)


def is_collision_free(
    people: People, speeds_mps: Floats, horizon_s: float, margin_m: float
) -> npt.NDArray[np.bool_]:
    """Return True for each of G speeds without a collision within a horizon, (..., G).

    Args:
        people: Arrays (..., P).
        speeds_mps: Speeds to try, (G,) or (..., 1, G).
        horizon_s: Later collisions do not count.
        margin_m: Added to the sum of the radii.
    """
    x, y, vx, vy = (values[..., None] for values in people[:4])
    time_s = time_to_collision(x, y, vx - speeds_mps, vy, RADII_M + margin_m)
    is_met = (time_s <= horizon_s) & people.is_there[..., None]
    return np.asarray(~is_met.any(axis=-2))


def largest_free(shares: Floats, is_free: npt.NDArray[np.bool_]) -> Floats:
    """Return the first free one of G shares, 0 if none is free: (..., G) to (...)."""
    return np.where(is_free.any(axis=-1), shares[is_free.argmax(axis=-1)], 0.0)
