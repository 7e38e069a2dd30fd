"""Velocity obstacle in one dimension, with optional shared responsibility.

Fiorini and Shiller (1998), Motion planning in dynamic environments using velocity obstacles: a
constant velocity is forbidden if it leads to a collision within a horizon. Van den Berg, Lin and
Manocha (2008), Reciprocal velocity obstacles for real-time multi-agent navigation: if others avoid
too, each agent contributes a share r of the change, so that a new speed v' counts as

    v + (v' - v)/r

with r = 1/2 among equals, as in ORCA (van den Berg et al. 2011), and r = 1 if others do not avoid.
The policy selects the largest allowed speed of a grid, and stops if all are forbidden.

The robot cannot leave its path, so it must stop for people who walk toward it. With r = 1 this is
the rule ``ttc`` on a finer grid. Not modeled: ORCA's half planes, which in one dimension leave an
interval of this set. Discs have the size of personal space, not of bodies; the size matters more
than the horizon.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic.dataclasses import dataclass

from hazbot_gym.core.proxemics import PERSONAL_M
from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import people_seen
from hazbot_gym.policies.robot import NOMINAL_MPS
from hazbot_gym.policies.ttc import is_collision_free, largest_free
from hazbot_gym.task.observation import layout_of

SHARES = np.linspace(1.0, 0.0, 21)  # of the nominal speed


@dataclass(frozen=True, config=OPTIONS)
class VelocityObstacle(PeopleRule):
    """Drives at the largest speed outside all velocity obstacles."""

    horizon_s: Annotated[float, Ge(0)] = 2.0  # later collisions are ignored
    responsibility: Annotated[float, Gt(0), Le(1)] = 0.5  # r
    margin_m: Annotated[float, Ge(0)] = PERSONAL_M  # added to the radii; the sweep parameter
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the largest allowed share; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        own_mps = seen["speed_mps"][..., None, None]
        alone_mps = own_mps + (SHARES * self.nominal_mps - own_mps) / self.responsibility
        is_free = is_collision_free(people_seen(seen), alone_mps, self.horizon_s, self.margin_m)
        return largest_free(SHARES, is_free)
