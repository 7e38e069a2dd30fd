"""Speed and separation monitoring (SSM) as a policy: the largest permitted speed.

``strict`` assumes that every person approaches at 1.6 m/s, as ISO 13855 requires without
measurement. ``directional`` uses each person's measured approach speed along the line of sight, and
0 for receding people. In narrow places, ``strict`` almost stands still; ``directional`` is the
practical variant. On the sonar tier both use ``sonar_estimate``, which has blind sectors. Formula
and source: ``core/ssm.py``.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.ssm import SsmThresholds, permitted_speed
from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.people_seen import clearances_m, of_people
from hazbot_gym.policies.robot import NOMINAL_MPS
from hazbot_gym.task.observation import layout_of


@dataclass(frozen=True, config=OPTIONS)
class Ssm(PeopleRule):
    """Drives at the largest speed that keeps the protective separation distance to all people."""

    mode: Literal["strict", "directional"] = "strict"
    margin_m: Annotated[float, Ge(-0.55)] = 0.0  # added to the distance; the sweep parameter
    nominal_mps: Annotated[float, Gt(0)] = NOMINAL_MPS  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the smallest permitted share over all people; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        approach_mps = None
        if self.mode == "directional":
            own_mps = seen["speed_mps"][..., None] * of_people(seen, "bearing_cos")
            approach_mps = np.maximum(of_people(seen, "closing_mps") - own_mps, 0.0)
        spare_m = clearances_m(seen) - self.margin_m
        permitted_mps = permitted_speed(spare_m, SsmThresholds(), approach_mps).min(axis=-1)
        share: Floats = np.clip(permitted_mps / self.nominal_mps, 0.0, 1.0)
        return share
