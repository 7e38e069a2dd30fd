"""Frame and View: the content of a picture and its camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.sensor_ring import PAPER, Sensors
from hazbot_gym.core.state import PRESENT, ROBOT_RADIUS_M, Floats, Place, Records
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.envs.plume import GasFrame

PX_PER_M = 64.0  # fixed scale for small places, so that robots have equal size
FARTHEST_PX_PER_M = 48.0  # below this scale, the view follows the robot
MARGIN_M, LEAST_MARGIN_M = 1.6, 0.8  # margin around the path: default and maximum
SMALLEST, LARGEST = (880, 416), (1152, 656)  # width and height of a scene, pixels
PANEL_TERMS = 7  # reward terms in a panel without a further row
MULTIPLE = 16  # divisor of both sides; required by video codecs


class Frame(NamedTuple):
    """Content of a picture.

    Attributes:
        place: Walls and path.
        x_m: The robot's position.
        y_m: The same, other axis.
        theta_rad: Its heading.
        people: (n,) records of type ``PERSON``; absent people are left out.
        patterns: Index into ``PATTERN_NAMES`` per person; other values for no pattern.
        ranges_m: (sensors,) last ultrasonic readings; empty for none.
        sonar: What these sensors have in common.
        ring: Where they point.
        trail: (k, 2) earlier positions of the robot [m].
        radius_m: The robot's radius.
        castor_rad: Angle of the castor, positive in left turns.
        speed_mps: Actual speed.
        command_mps: Speed commanded by the policy.
        top_speed_mps: Full length of the speed bar.
        terms: Weighted reward terms of the last decision, by name.
        total_reward: Return so far.
        time_s: Time since the start of the episode.
        outcome: Outcome of the episode, or "" while it runs.
        gas: Leak, plume and gas sensor; None without gas.
        caption: Text in the corner of the scene, such as the policy's name.
    """

    place: Place
    x_m: float
    y_m: float
    theta_rad: float
    people: Records
    patterns: Sequence[int]
    ranges_m: Floats
    sonar: Ultrasonic = Ultrasonic()
    ring: Sensors = PAPER
    trail: Floats = np.empty((0, 2))
    radius_m: float = ROBOT_RADIUS_M
    castor_rad: float = 0.0
    speed_mps: float = 0.0
    command_mps: float = 0.0
    top_speed_mps: float = 0.5
    terms: Mapping[str, float] = {}
    total_reward: float = 0.0
    time_s: float = 0.0
    outcome: str = ""
    gas: GasFrame | None = None
    caption: str = ""

    @property
    def has_strip(self) -> bool:
        """True if the panel has a further row: for gas, or for the reward terms of users."""
        return self.gas is not None or len(self.terms) > PANEL_TERMS


def between(before: Frame, after: Frame, share: float) -> Frame:
    """Return the frame a share of the way from one decision to the next, by straight lines.

    Robot and people move; numbers, readings and outcome stay those of the first frame.
    """

    def mix(a: float, b: float) -> float:
        return a + share * (b - a)

    people = before.people.copy()
    moving = (people["status"] == PRESENT) & (after.people["status"] == PRESENT)
    for axis in ("x", "y"):
        people[axis][moving] = mix(people[axis][moving], after.people[axis][moving])
    return before._replace(
        x_m=mix(before.x_m, after.x_m),
        y_m=mix(before.y_m, after.y_m),
        theta_rad=mix(before.theta_rad, after.theta_rad),
        people=people,
    )


class View(NamedTuple):
    """Camera of a scene: center point and scale."""

    x_m: float
    y_m: float
    px_per_m: float
    width: int
    height: int

    def pixels(self, points: Floats) -> Floats:
        """Return (..., 2) pixel columns and rows of points (..., 2) [m]."""
        middle = np.array([self.width, self.height]) / 2.0
        offset = np.asarray(points) - np.array([self.x_m, self.y_m])
        pixels: Floats = middle + self.px_per_m * offset * np.array([1.0, -1.0])
        return pixels


def size_of(place: Place) -> tuple[int, int]:
    """Return width and height of a place's scene [px]: room for its path, within limits."""
    low, high = _extent(place)
    wanted = PX_PER_M * (high - low + 2.0 * MARGIN_M)
    width, height = np.clip(wanted, SMALLEST, LARGEST) // MULTIPLE * MULTIPLE
    return int(width), int(height)


def view_of(place: Place, width: int, height: int) -> View | None:
    """Return the view of the whole path, or None if the scale would be too small."""
    low, high = _extent(place)
    scale = float(min(np.array([width, height]) / (high - low + 2.0 * LEAST_MARGIN_M)))
    if scale < FARTHEST_PX_PER_M:
        return None
    x_m, y_m = (low + high) / 2.0
    return View(float(x_m), float(y_m), min(scale, PX_PER_M), width, height)


def _extent(place: Place) -> tuple[Floats, Floats]:
    """Return the corners (2,), (2,) of the box around a path [m]."""
    length = path_length(place.path.view(np.recarray))
    points = sample_path(place.path, np.linspace(0.0, length, 65))[:, :2]
    return points.min(axis=0), points.max(axis=0)
