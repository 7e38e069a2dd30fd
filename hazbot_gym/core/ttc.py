"""Time to collision of two discs at constant velocities (Hayward 1972, in the plane).

The distance of the centres reaches the sum of the radii when ``|p + w t| = r``, a quadratic in t.
The common approximation, distance by closing speed along the line of sight, reports collisions of
passing discs, and true collisions too early or too late.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats


def time_to_collision(
    px: npt.ArrayLike, py: npt.ArrayLike, wx: npt.ArrayLike, wy: npt.ArrayLike, r: npt.ArrayLike
) -> Floats:
    """Return the smallest t >= 0 with ``|p + w t| <= r`` [s]; infinite if they never touch.

    ``t = (|p|^2 - r^2) / (-p.w + sqrt((p.w)^2 - |w|^2 (|p|^2 - r^2)))``, 0 if they touch already.
    All arguments broadcast against each other.

    Args:
        px: Position of the other relative to oneself [m].
        py: The same, other axis [m].
        wx: Velocity of the other relative to oneself [m/s].
        wy: The same, other axis [m/s].
        r: Sum of the radii [m].
    """
    px, py, wx, wy, r = (np.asarray(given, np.float64) for given in (px, py, wx, wy, r))
    gap = px * px + py * py - r * r
    approach = -(px * wx + py * wy)
    discriminant = approach * approach - (wx * wx + wy * wy) * gap
    with np.errstate(divide="ignore", invalid="ignore"):
        time_s = gap / (approach + np.sqrt(discriminant))
    meets = (approach > 0.0) & (discriminant >= 0.0)
    return np.where(gap <= 0.0, 0.0, np.where(meets, time_s, np.inf))
