"""Random speeds, the customary lower reference and the widest data set for offline learning."""

from __future__ import annotations

from hashlib import blake2b
from typing import Annotated

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Lt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.base import OPTIONS, Rule
from hazbot_gym.policies.guard import Observations


@dataclass(frozen=True, config=OPTIONS)
class RandomSpeed(Rule):
    """Draws a speed uniformly from 0 to nominal for each decision.

    The draw is a hash of the observation, so it is the same alone and in any batch.
    """

    seed: Annotated[int, Ge(0), Lt(2**63)] = 0

    def speed_share(self, observation: Observations) -> Floats:
        """Return the shares drawn for observations; see ``base.Rule``."""
        rows = np.asarray(observation, np.float32)
        shares: Floats = np.apply_along_axis(self._draw, -1, rows)
        return shares

    def _draw(self, row: npt.NDArray[np.float32]) -> float:
        key = self.seed.to_bytes(8, "little")
        drawn = blake2b(row.tobytes(), digest_size=8, key=key).digest()
        return int.from_bytes(drawn, "little") / 2.0**64
