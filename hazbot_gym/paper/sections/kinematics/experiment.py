"""Section 3.1: castor geometry from the paper's equations, compared with its stated values.

"When the robot turns 90 deg, using the equations we can calculate that the rear wheel rotation
angle is approximately 20 deg. The rotation speed ratio is approximately 1.44, and the minimum
turning radius R is approximately 1.17 m." One of the three determines the other two.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from hazbot_gym.errors import MissingExtra

try:
    from scipy.optimize import brentq
except ImportError as error:
    raise MissingExtra("scipy", "study") from error

from hazbot_gym.core.kinematics import (
    Chassis,
    castor_angle,
    radius_from_castor,
    ratio_from_castor,
    turning_radius,
    wheel_ratio,
)

CHASSIS = Chassis()
PAPER_BETA_RAD, PAPER_RADIUS_M, PAPER_RATIO = math.radians(20.0), 1.17, 1.44


class Turn(NamedTuple):
    """A turn: consistent castor angle, radius and wheel ratio."""

    start: str  # value taken from the paper
    beta_rad: float
    radius_m: float
    ratio: float


def from_angle(start: str, beta_rad: float, chassis: Chassis = CHASSIS) -> Turn:
    """Return the turn of a castor angle (eqs 5, 6)."""
    radius, ratio = radius_from_castor(beta_rad, chassis), ratio_from_castor(beta_rad, chassis)
    return Turn(start, beta_rad, radius, ratio)


def castor_table() -> list[Turn]:
    """Return the turn from each of the paper's three numbers, and under other readings."""
    by_ratio = castor_angle(turning_radius(PAPER_RATIO, CHASSIS), CHASSIS)
    by_radius = castor_angle(PAPER_RADIUS_M, CHASSIS)
    L1, L2, L3 = CHASSIS.L1, CHASSIS.L2, CHASSIS.L3
    short_m = (L1 + L2 + L3 * math.cos(PAPER_BETA_RAD)) / math.tan(PAPER_BETA_RAD)
    half = from_angle("", PAPER_BETA_RAD, CHASSIS._replace(L=2.0 * CHASSIS.L))
    return [
        from_angle("an angle of 20 deg", PAPER_BETA_RAD),
        from_angle("a ratio of 1.44", by_ratio),
        from_angle("a radius of 1.17 m", by_radius),
        Turn(
            "20 deg, L3 cos(beta) for L3/cos(beta)",
            PAPER_BETA_RAD,
            short_m,
            wheel_ratio(short_m, CHASSIS),
        ),
        half._replace(start="20 deg, L as half the track (excluded)"),
    ]


def nearest_chassis_m() -> float:
    """Return the L1 for which 20 deg gives exactly 1.17 m [m]."""
    return float(
        brentq(
            lambda L1: radius_from_castor(PAPER_BETA_RAD, CHASSIS._replace(L1=L1)) - PAPER_RADIUS_M,
            0.1,
            0.4,
        )
    )
