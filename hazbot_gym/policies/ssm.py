"""Speed and separation monitoring as a policy: as fast as the nearest person permits.

``strict`` takes everybody for approaching at 1.6 m/s, as ISO 13855 asks where nothing is measured.
``directional`` takes the speed with which each person really approaches along the line of sight,
and nothing for people who walk away. In narrow places the first all but stands; the second is what
a careful engineer would build. On the sonar tier both see the people of ``sonar_estimate``, and
nobody in its blind sectors. Formula and source: ``core/ssm.py``.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from hazbot_gym.core.ssm import SsmThresholds, permitted_speed
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.policies.base import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.task.observation import PERSON_SLOTS, layout_of


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Ssm(PeopleRule):
    """Drives at the largest speed whose protective separation distance is kept to everybody."""

    mode: Literal["strict", "directional"] = "strict"
    margin_m: Annotated[float, Ge(-0.55)] = 0.0  # added to the distance; the knob of the family
    nominal_mps: Annotated[float, Gt(0)] = 0.5  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the share that the strictest person permits; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        permitted = [self._beside(seen, i) for i in range(PERSON_SLOTS)]
        return np.clip(np.min(permitted, axis=0) / self.nominal_mps, 0.0, 1.0)

    def _beside(self, seen: dict[str, Floats], i: int) -> Floats:
        """Return the speed that person i permits, infinite if there is none."""
        clearance_m = seen[f"person{i}_distance_m"] - ROBOT_RADIUS_M - PERSON_RADIUS_M
        approach_mps = None
        if self.mode == "directional":
            own_mps = seen["speed_mps"] * seen[f"person{i}_bearing_cos"]
            approach_mps = np.maximum(seen[f"person{i}_closing_mps"] - own_mps, 0.0)
        speed_mps = permitted_speed(clearance_m - self.margin_m, SsmThresholds(), approach_mps)
        return np.where(seen[f"person{i}_present"] > 0.5, speed_mps, np.inf)
