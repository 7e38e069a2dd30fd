"""A time-to-collision governor: the largest speed at which no collision is near.

Of a grid of speeds it takes the largest at which the time to collision with everybody seen exceeds
a horizon, each taken to keep its velocity; it stops if there is none. In one dimension this is the
choice of a velocity obstacle with a time limit (Fiorini and Shiller 1998, who leave out collisions
later than a horizon). Bodies count as larger by a margin: with none the horizon hardly moves how
near people are driven past, only what is left for braking. Formula and source: ``core/ttc.py``.

The observation says how fast a person is across the line of sight, but not to which side. That
follows from the closest approach while the robot drives; while it stands, the worse side counts.
On the sonar tier everybody is taken to walk along the line of sight (``sonar_estimate``), so that
even who would pass beside stops the robot, and nobody in a blind sector does.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from hazbot_gym.core.proxemics import INTIMATE_M
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.core.ttc import time_to_collision
from hazbot_gym.policies.base import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.task.observation import PERSON_SLOTS, layout_of

SHARES = np.array([1.0, 0.75, 0.5, 0.25, 0.0])  # of the nominal speed: the paper's levels
SIDES = np.array([1.0, -1.0])  # left and right
SAME_M = 0.02  # closest approaches that differ by less do not tell the two sides apart
RADII_M = ROBOT_RADIUS_M + PERSON_RADIUS_M
PERSON_FIELDS = (
    "present",
    "distance_m",
    "bearing_sin",
    "bearing_cos",
    "speed_mps",
    "closing_mps",
    "closest_m",
)


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Ttc(PeopleRule):
    """Drives at the largest speed that leads to no collision within a horizon."""

    horizon_s: Annotated[float, Ge(0)] = 2.0  # the knob of the family
    margin_m: Annotated[float, Ge(0)] = INTIMATE_M  # added to the radii, as C is in ``core/ssm.py``
    nominal_mps: Annotated[float, Gt(0)] = 0.5  # speed of action +1

    def speed_share(self, observation: Observations) -> Floats:
        """Return the largest share without a near collision; see ``base.Rule``."""
        seen = layout_of(observation).decode(observation)
        people = {
            name: np.stack([seen[f"person{i}_{name}"] for i in range(PERSON_SLOTS)], axis=-1)
            for name in PERSON_FIELDS
        }
        speeds_mps, radii_m = SHARES * self.nominal_mps, RADII_M + self.margin_m
        time_s = _times_s(people, seen["speed_mps"][..., None], speeds_mps, radii_m)
        is_there = (people["present"] > 0.5)[..., None]
        is_free = ((time_s > self.horizon_s) | ~is_there).all(axis=-2)
        return np.where(is_free.any(axis=-1), SHARES[is_free.argmax(axis=-1)], 0.0)


def _times_s(
    people: dict[str, Floats], own_mps: Floats, speeds_mps: Floats, radii_m: float
) -> Floats:
    """Return the time to collision with each person at each of G speeds: (..., K, G).

    With p the unit vector to a person and n the one across it to the left, the person's velocity is
    ``q_p p +- q_n n``: q_p follows from the closing speed, q_n from q_p and the speed.

    Args:
        people: Person fields, arrays (..., K).
        own_mps: (..., 1) speed of the robot.
        speeds_mps: (G,) speeds to try.
        radii_m: Sum of the radii.
    """
    sine, cosine = people["bearing_sin"], people["bearing_cos"]
    px, py = people["distance_m"] * cosine, people["distance_m"] * sine
    along = own_mps * cosine - people["closing_mps"]
    across = np.sqrt(np.maximum(people["speed_mps"] ** 2 - along**2, 0.0))
    across = np.multiply.outer(SIDES, across)  # (2, ..., K) like all that follows
    vx, vy = along * cosine - across * sine, along * sine + across * cosine
    off_m = np.abs(_closest_m(px, py, vx - own_mps, vy) - people["closest_m"])
    is_possible = off_m <= off_m.min(axis=0) + SAME_M
    wx, wy = vx[..., None] - speeds_mps, vy[..., None]
    time_s = time_to_collision(px[..., None], py[..., None], wx, wy, radii_m)
    return np.where(is_possible[..., None], time_s, np.inf).min(axis=0)


def _closest_m(px: Floats, py: Floats, wx: Floats, wy: Floats) -> Floats:
    """Return the distance at the closest approach to come; see ``patterns.closest_approach``."""
    squared = np.maximum(wx**2 + wy**2, 1e-12)
    time_s = np.maximum(-(px * wx + py * wy), 0.0) / squared
    return np.hypot(px + wx * time_s, py + wy * time_s)
