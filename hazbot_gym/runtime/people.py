"""Tracked people as a robot knows them, and their fields in an observation.

The walking pattern of a person is found as in the simulator (``sim/perception.py``): within Hall's
social distance, and held there, so that it describes the encounter and not the current geometry.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple

from hazbot_gym.config import Tracker
from hazbot_gym.core.patterns import Thresholds, classify
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.core.state import BESIDE, NO_PATTERN, ROBOT, TRACK, records
from hazbot_gym.task.observation import TRACKER_RANGE_M, person_fields


class Person(NamedTuple):
    """A tracked person in the robot's frame: x ahead, y to the left, from the centre of its axle.

    Velocities are over ground, not relative to the robot, along the same two axes.
    """

    x_m: float
    y_m: float
    vx_mps: float
    vy_mps: float
    track: Hashable = None  # the tracker's id, by which a walking pattern is held; None: it is not


Given = Sequence[Person | Mapping[str, float]]


def as_people(given: Given) -> list[Person]:
    """Return people from named tuples, or from mappings with the same fields.

    Raises:
        TypeError: A field is missing or unknown.
    """
    return [Person(**each) if isinstance(each, Mapping) else Person(*each) for each in given]


class Encounters:
    """Walking patterns of the people around the robot, each held by the id of its track."""

    def __init__(self, nominal_speed_mps: float, person_slots: int) -> None:
        self._speed_mps = nominal_speed_mps  # that a stopped robot intends
        self._slots = person_slots
        self._held: dict[Hashable, int] = {}
        self._thresholds = Thresholds(moving_mps=Tracker().moving_mps)

    def forget(self) -> None:
        """Forget all patterns."""
        self._held = {}

    def fields(self, people: Sequence[Person], speed_mps: float) -> dict[str, float]:
        """Return the person fields of an observation, by name and in their units.

        Args:
            people: All people that the tracker reports; those beyond the tracker's range in the
                simulator are left out.
            speed_mps: Speed of the robot.
        """
        near = [one for one in people if math.hypot(one.x_m, one.y_m) <= TRACKER_RANGE_M]
        labels = [self._pattern(one) for one in near]
        self._held = {
            one.track: label
            for one, label in zip(near, labels, strict=True)
            if one.track is not None and label not in (NO_PATTERN, BESIDE)
        }
        robot, tracks = records(ROBOT, 1), records(TRACK, len(near))
        robot["v"] = speed_mps
        for track, one, label in zip(tracks, near, labels, strict=True):
            track["visible"], track["pattern"] = 1, label
            track["x"], track["y"], track["vx"], track["vy"] = one[:4]
        return person_fields(tracks, robot, self._slots)

    def _pattern(self, one: Person) -> int:
        if math.hypot(one.x_m, one.y_m) > SOCIAL_M:
            return NO_PATTERN
        if one.track is not None and one.track in self._held:
            return self._held[one.track]
        return classify(
            one.x_m, one.y_m, 0.0, self._speed_mps, one.vx_mps, one.vy_mps, self._thresholds
        )
