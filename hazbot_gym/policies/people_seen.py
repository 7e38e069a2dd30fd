"""Positions and velocities of observed people, in the robot's frame."""

from __future__ import annotations

from itertools import count, takewhile
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats

RADII_M = ROBOT_RADIUS_M + PERSON_RADIUS_M


class People(NamedTuple):
    """People relative to the robot, x ahead, y to the left, velocities over ground: (..., K).

    K is the number of slots.
    """

    x_m: Floats
    y_m: Floats
    vx_mps: Floats
    vy_mps: Floats
    is_there: npt.NDArray[np.bool_]


def of_people(seen: dict[str, Floats], field: str) -> Floats:
    """Return a field of the people in a decoded observation, (..., K) for K slots."""
    names = takewhile(seen.__contains__, (f"person{i}_{field}" for i in count()))
    return np.stack([seen[name] for name in names], axis=-1)


def clearances_m(seen: dict[str, Floats]) -> Floats:
    """Return the clearance to each person, surface to surface, (..., K); infinite if empty."""
    is_there = of_people(seen, "present") > 0.5
    return np.where(is_there, of_people(seen, "distance_m") - RADII_M, np.inf)


def people_seen(seen: dict[str, Floats]) -> People:
    """Return positions and velocities of people from a decoded observation of fields (...).

    With p the unit vector to a person and n the unit vector perpendicular to p, to the left, the
    person's velocity is ``q_p p + q_n n``: q_p follows from the closing speed c and the robot's
    velocity v as ``v.p - c``, and q_n is observed.
    """
    sine, cosine, distance_m, closing_mps, across, present = (
        of_people(seen, field)
        for field in (
            "bearing_sin", "bearing_cos", "distance_m", "closing_mps", "across_mps", "present"
        )
    )  # fmt: skip
    along = seen["speed_mps"][..., None] * cosine - closing_mps
    return People(
        x_m=distance_m * cosine,
        y_m=distance_m * sine,
        vx_mps=along * cosine - across * sine,
        vy_mps=along * sine + across * cosine,
        is_there=present > 0.5,
    )


def mirrored(people: People) -> People:
    """Return the people with velocities mirrored at the line of sight, ``q_p p - q_n n``."""
    x, y, vx, vy, _ = people
    twice_q_p = 2.0 * (x * vx + y * vy) / np.maximum(x**2 + y**2, 1e-12)  # over the distance
    return people._replace(vx_mps=twice_q_p * x - vx, vy_mps=twice_q_p * y - vy)
