"""Observations with the fields of the gas sensor left out."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.task.observation import layout_of, layout_with, selected


def without_gas(observation: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return observations (..., width) as of the same environment without gas."""
    given = layout_of(observation)
    return selected(observation, layout_with(given.sensors, given.person_slots, False))
