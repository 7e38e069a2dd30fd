"""Lattice of speeds and places reachable in whole decisions, all multiples of one length."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput

LEVELS = 11  # speeds of the lattice, 0 to nominal


class Lattice(NamedTuple):
    """Transitions between speeds within a decision, and the distances covered."""

    unit_m: float  # all distances are multiples of this length
    speeds_mps: Floats  # (V,)
    ways: Ints  # (V, V) distance per transition in units, -1 if forbidden
    substeps_mps: Floats  # (V, V, K) speed in each physics step of the decision


def lattice_of(config: Config) -> Lattice:
    """Return the lattice of a config's clock and slew limits.

    Raises:
        InvalidInput: the limits do not connect the speeds in whole decisions.
    """
    clock, drive = config.clock, config.drive
    speeds = np.linspace(0.0, drive.nominal_speed_mps, LEVELS)
    substeps = clock.physics_per_social * clock.social_per_decision
    ramp = np.arange(1, substeps + 1) * clock.physics_s
    change = speeds[None, :] - speeds[:, None]
    up = np.minimum(ramp * drive.acceleration_mps2, change[..., None].clip(0.0))
    down = np.maximum(-ramp * drive.deceleration_mps2, change[..., None].clip(None, 0.0))
    profile = speeds[:, None, None] + up + down
    reaches = np.abs(profile[..., -1] - speeds[None, :]) < 1e-9
    ways_m = profile.sum(axis=-1) * clock.physics_s
    unit_m = _common_unit(ways_m[reaches])
    ways = np.where(reaches, np.rint(ways_m / unit_m), -1).astype(np.int64)
    if not all(reaches[i, i + 1] and reaches[i + 1, i] for i in range(LEVELS - 1)):
        raise InvalidInput(
            "drive: the slew limits must let the robot gain and lose a tenth of its nominal speed "
            f"in a decision; given {drive.acceleration_mps2} and {drive.deceleration_mps2} m/s^2"
        )
    return Lattice(unit_m, speeds, ways, profile)


def _common_unit(ways_m: Floats) -> float:
    """Return the greatest common divisor of all distances [m]."""
    nanometres = np.rint(ways_m[ways_m > 0.0] * 1e9).astype(np.int64)
    return math.gcd(*nanometres.tolist()) * 1e-9
