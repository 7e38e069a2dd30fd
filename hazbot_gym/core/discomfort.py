"""Discomfort of a person near the robot, as people rate it.

    D(c, phi) = min(1, exp(-(c + r - d_c) / (L exp(a cos phi))))

with the clearance c, the sum r of the radii of robot and person, and the robot's bearing phi as
seen by the person, 0 if the person faces the robot. The constants are fitted to ratings of pictures
of a robot among people (SocNav1; ``hazbot calibrate --ratings``, docs/discomfort.md), without the
discomfort that raters state far from all people. Among several people the largest D counts.

In motion the hazard grows with the kinetic energy: the discomfort of a robot at speed v is charged
in proportion to (v / v_n)^2.
"""

from __future__ import annotations

import math

from hazbot_gym.core.elementary import decay
from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M

CONTACT_M = 0.330  # d_c, distance between centers of full discomfort
LENGTH_M = 0.636  # L, decay length
DIRECTION = 0.549  # a, effect of the direction
STROLL_MPS = 0.3  # a slower person's direction counts in proportion to its speed
FRONT_LENGTH_M = LENGTH_M * math.exp(DIRECTION)  # decay length in front of a person


@scalar
def discomfort(clearance_m: float, facing: float) -> float:
    """Return the discomfort in [0, 1] at a clearance and the cosine of the robot's bearing."""
    return decay(-remoteness(clearance_m, facing))


@scalar
def remoteness(clearance_m: float, facing: float) -> float:
    """Return the distance beyond ``CONTACT_M`` in decay lengths, -log D; negative within.

    The least remote of several people is the one whose discomfort is largest.
    """
    beyond_m = clearance_m + PERSON_RADIUS_M + ROBOT_RADIUS_M - CONTACT_M
    return beyond_m / (FRONT_LENGTH_M * decay(DIRECTION * (facing - 1.0)))


@scalar
def facing(x: float, y: float, vx: float, vy: float) -> float:
    """Return the cosine of the robot's bearing as seen by a person.

    A person faces its walking direction. Standing people have no known direction and count as seen
    from the side (0).

    Args:
        x: Position of the robot relative to the person [m].
        y: The same, other axis.
        vx: Velocity of the person [m/s].
        vy: The same, other axis.
    """
    scale = max(norm(vx, vy), STROLL_MPS) * max(norm(x, y), 1e-6)
    return (x * vx + y * vy) / scale
