"""Undo lag: inspects slowly while the gas, not the lagging reading, is worth it.

The first-order lag is inverted: a sensor at reading r whose rate is dr/dt heads for

    u = r + tau dr/dt

the reading that it would reach if the gas stayed. With the filtered rate of the observation, which
averages over seconds, this is a matched filter of the sensor's step response against white noise.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Le
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.gas_rule import GasRule, PeopleRules


@dataclass(frozen=True, config=OPTIONS)
class UndoLag(GasRule):
    """Slows down while the reading that the sensor heads for exceeds a level."""

    level: Annotated[float, Ge(-10), Le(10)] = 0.5  # of the alarm threshold; the sweep parameter
    slow: Annotated[float, Ge(0), Le(1)] = 0.2  # share of the nominal speed
    lag_s: Annotated[float, Ge(0), Le(60)] = 3.44  # tau of the sensor's rise (TGS2611)
    people: PeopleRules = "none"

    def inspects(self, seen: dict[str, Floats]) -> npt.NDArray[np.bool_]:
        """Return True where the sensor heads for the level; see ``GasRule``."""
        return seen["gas_reading"] + self.lag_s * seen["gas_rate_per_s"] > self.level
