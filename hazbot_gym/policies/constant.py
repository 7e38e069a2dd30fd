"""Constant speed policy."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Le
from pydantic.dataclasses import dataclass

from hazbot_gym.policies.base import OPTIONS, Rule
from hazbot_gym.policies.guard import Observations


@dataclass(frozen=True, config=OPTIONS)
class Constant(Rule):
    """Drives at a fixed share of the nominal speed."""

    fraction: Annotated[float, Ge(0), Le(1)] = 1.0

    def speed_share(self, observation: Observations) -> npt.NDArray[np.float64]:
        """Return the same share for every observation; see ``base.Rule``."""
        return np.full(np.shape(observation)[:-1], self.fraction)
