"""Positions and velocities of observed people, in the robot's frame.

The observation has the speed across the line of sight, but not its sign. The sign follows from the
closest approach while the robot drives. While it stands, the sign is ambiguous: then the person
appears twice, once per sign, and a worst-case rule uses the worse one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.task.observation import PERSON_SLOTS

RADII_M = ROBOT_RADIUS_M + PERSON_RADIUS_M
SIDES = np.array([[1.0], [-1.0]])  # left and right
SAME_M = 0.02  # closest approaches that differ by less leave the sign ambiguous


class People(NamedTuple):
    """People relative to the robot, x ahead, y to the left, velocities over ground: (..., P).

    P is twice the number of slots: each person with both signs of the lateral velocity.
    """

    x_m: Floats
    y_m: Floats
    vx_mps: Floats
    vy_mps: Floats
    is_there: npt.NDArray[np.bool_]  # whether the person is present and the sign possible


def of_people(seen: dict[str, Floats], field: str) -> Floats:
    """Return a field of the people in a decoded observation, (..., K) for K slots."""
    return np.stack([seen[f"person{i}_{field}"] for i in range(PERSON_SLOTS)], axis=-1)


def clearances_m(seen: dict[str, Floats]) -> Floats:
    """Return the clearance to each person, surface to surface, (..., K); infinite if empty."""
    is_there = of_people(seen, "present") > 0.5
    return np.where(is_there, of_people(seen, "distance_m") - RADII_M, np.inf)


def people_seen(seen: dict[str, Floats]) -> People:
    """Return positions and velocities of people from a decoded observation of fields (...).

    With p the unit vector to a person and n the unit vector perpendicular to p, to the left, the
    person's velocity is ``q_p p +- q_n n``: q_p follows from the closing speed, q_n from q_p and
    the speed.
    """
    sine, cosine, distance_m, closing_mps, speed_mps, closest_m, present = (
        of_people(seen, field)[..., None, :]  # (..., 1, K), beside (..., 2, K) for the two sides
        for field in (
            "bearing_sin", "bearing_cos", "distance_m", "closing_mps", "speed_mps", "closest_m",
            "present",
        )
    )  # fmt: skip
    own_mps = seen["speed_mps"][..., None, None]
    px, py = distance_m * cosine, distance_m * sine
    along = own_mps * cosine - closing_mps
    across = SIDES * np.sqrt(np.maximum(speed_mps**2 - along**2, 0.0))
    vx, vy = along * cosine - across * sine, along * sine + across * cosine
    off_m = np.abs(_closest_m(px, py, vx - own_mps, vy) - closest_m)
    is_possible = off_m <= off_m.min(axis=-2, keepdims=True) + SAME_M
    both = np.broadcast_arrays(px, py, vx, vy, is_possible & (present > 0.5))
    return People(*(values.reshape(*values.shape[:-2], -1) for values in both))


def _closest_m(px: Floats, py: Floats, wx: Floats, wy: Floats) -> Floats:
    """Return the distance at the closest approach to come; see ``patterns.closest_approach``."""
    squared = np.maximum(wx**2 + wy**2, 1e-12)
    time_s = np.maximum(-(px * wx + py * wy), 0.0) / squared
    return np.hypot(px + wx * time_s, py + wy * time_s)
