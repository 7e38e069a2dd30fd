"""The simplest policy: one speed, whatever happens."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Le
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from hazbot_gym.policies.base import Actions, Observations, speed_action


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Constant:
    """Drives at a fixed share of the nominal speed and looks at nothing."""

    fraction: Annotated[float, Ge(0), Le(1)] = 1.0

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the same action for every observation; see ``base.Policy.predict``."""
        return speed_action(np.full(np.shape(observation)[:-1], self.fraction)), state
