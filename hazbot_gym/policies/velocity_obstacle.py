"""A velocity obstacle in one dimension, with the responsibility shared or not.

Fiorini and Shiller (1998), Motion planning in dynamic environments using velocity obstacles: a
velocity is forbidden if, kept, it meets somebody within a horizon. Van den Berg, Lin and Manocha
(2008), Reciprocal velocity obstacles for real-time multi-agent navigation: if the others avoid too,
each needs to make but a share r of the change, so that a new speed v' is as good as

    v + (v' - v)/r

would be alone; r = 1/2 among equals, as in ORCA (van den Berg et al. 2011), r = 1 if nobody else
avoids. Of a grid of speeds the largest that is not forbidden is taken, and none if all are.

The robot cannot leave its path, so that from whoever comes straight on only standing helps. With
r = 1 this is the rule ``ttc`` on a finer grid. Left out: ORCA's half planes, which in one dimension
leave an interval of this set. Discs are as wide as personal space, not as bodies: how wide counts
for more than how far the horizon is.
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
from hazbot_gym.policies.ttc import largest_free, meets_nobody
from hazbot_gym.task.observation import layout_of

SHARES = np.linspace(1.0, 0.0, 21)  # of the nominal speed


@dataclass(frozen=True, config=OPTIONS)
class VelocityObstacle(PeopleRule):
    """Drives at the largest speed outside everybody's velocity obstacle."""

    horizon_s: Annotated[float, Ge(0)] = 2.0  # later meetings do not count
    responsibility: Annotated[float, Gt(0), Le(1)] = 0.5  # r
    margin_m: Annotated[float, Ge(0)] = PERSONAL_M  # added to the radii; the knob of the family
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the largest share that is not forbidden; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        own_mps = seen["speed_mps"][..., None, None]
        alone_mps = own_mps + (SHARES * self.nominal_mps - own_mps) / self.responsibility
        is_free = meets_nobody(people_seen(seen), alone_mps, self.horizon_s, self.margin_m)
        return largest_free(SHARES, is_free)
