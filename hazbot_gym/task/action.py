"""Action: the commanded speed, scaled to [-1, 1].

    commanded speed = v_n (a + 1) / 2,  with the nominal speed v_n [m/s]

-1 is stop and +1 nominal speed. A discrete environment has the paper's five levels.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.geometry import clip
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import Floats

Actions = npt.NDArray[np.float32]

SPEED_LEVELS = (0.0, 0.25, 0.5, 0.75, 1.0)  # the paper's stop, 25, 50, 75, 100 %
ACTION_TOLERANCE = 1e-6  # excess of a bound by rounding to float32


@scalar
def commanded_speed(action: float, nominal_speed_mps: float) -> float:
    """Return the commanded speed of an action [m/s]; an action out of bounds is clipped."""
    return nominal_speed_mps * 0.5 * (clip(action, -1.0, 1.0) + 1.0)


def level_action(level: int) -> float:
    """Return the action of a speed level."""
    return 2.0 * SPEED_LEVELS[level] - 1.0


def speed_action(fraction: npt.ArrayLike) -> Actions:
    """Return the actions for fractions of the nominal speed in [0, 1]: shape (...) to (..., 1)."""
    return np.asarray(2.0 * np.asarray(fraction, np.float32) - 1.0, np.float32)[..., np.newaxis]


def action_of_speed(speed_mps: Floats, nominal_speed_mps: float) -> Floats:
    """Return the actions that command some speeds, the inverse of ``commanded_speed``."""
    actions: Floats = 2.0 * speed_mps / nominal_speed_mps - 1.0
    return actions.clip(-1.0, 1.0)


def nearest_level(
    actions: npt.NDArray[np.generic], levels: int = len(SPEED_LEVELS)
) -> npt.NDArray[np.int64]:
    """Return the index of the nearest of evenly spaced levels for actions in [-1, 1]."""
    top = levels - 1
    return np.clip(np.rint((np.asarray(actions, np.float64) + 1.0) / 2.0 * top), 0, top).astype(
        np.int64
    )
