"""Slow on rise: inspects slowly while the reading of the gas sensor rises.

The sensor lags behind the gas by seconds. A rising reading says that there is more gas than it
shows; a slow robot gives it the time to reach the alarm.
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
class SlowOnRise(GasRule):
    """Slows down while the rate of the reading exceeds a threshold."""

    rise_per_s: Annotated[float, Ge(-5), Le(5)] = 0.1  # the sweep parameter
    slow: Annotated[float, Ge(0), Le(1)] = 0.2  # share of the nominal speed
    people: PeopleRules = "none"

    def inspects(self, seen: dict[str, Floats]) -> npt.NDArray[np.bool_]:
        """Return True where the reading rises; see ``GasRule``."""
        return seen["gas_rate_per_s"] > self.rise_per_s
