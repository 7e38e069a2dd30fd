"""A time-to-collision governor: the largest speed at which no collision is near.

Of a grid of speeds it takes the largest at which the time to collision with everybody seen exceeds
a horizon, each taken to keep its velocity; it stops if there is none. In one dimension this is the
choice of a velocity obstacle with a time limit (Fiorini and Shiller 1998, who leave out collisions
later than a horizon). Bodies count as larger by a margin: with none the horizon hardly moves how
near people are driven past, only what is left for braking. Formula and source: ``core/ttc.py``.

On the sonar tier everybody is taken to walk along the line of sight (``sonar_estimate``), so that
even who would pass beside stops the robot, and nobody in a blind sector does.
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

    horizon_s: Annotated[float, Ge(0)] = 2.0  # the knob of the family
    margin_m: Annotated[float, Ge(0)] = INTIMATE_M  # added to the radii, as C is in ``core/ssm.py``
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the largest share without a near collision; see ``base.Rule``."""
        people = people_seen(layout_of(observation).decode(observation))
        is_free = meets_nobody(people, SHARES * self.nominal_mps, self.horizon_s, self.margin_m)
        return largest_free(SHARES, is_free)


def meets_nobody(
    people: People, speeds_mps: Floats, horizon_s: float, margin_m: float
) -> npt.NDArray[np.bool_]:
    """Return at which of G speeds the robot meets nobody within a horizon, (..., G).

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
    """Return the first of G shares that is free, 0 if none is: (..., G) to (...)."""
    return np.where(is_free.any(axis=-1), shares[is_free.argmax(axis=-1)], 0.0)
