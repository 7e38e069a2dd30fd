"""The picture of a moment: place, robot, what it hears, people and their personal space.

Drawn offscreen at twice the size and scaled down, which smooths every edge; no display is needed.
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.kinematics import Chassis
from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, SOCIAL_M
from hazbot_gym.core.state import PATTERN_NAMES, PRESENT, Floats, Place, Records
from hazbot_gym.core.ultrasonic import Ultrasonic, mounting
from hazbot_gym.errors import MissingExtra

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame
except ImportError as error:
    raise MissingExtra("pygame-ce", "render") from error

Color = tuple[int, int, int]
Image = npt.NDArray[np.uint8]

SMOOTHING = 2  # drawn this much larger, then scaled down
MARGIN_M = 2.0  # seen around the path where the whole of it fits
CLOSEST_PX_PER_M, FARTHEST_PX_PER_M = (
    90.0,
    40.0,
)  # where it does not fit, the view follows the robot
DASH_M = 0.2

FLOOR: Color = (250, 249, 246)
INK: Color = (44, 49, 58)
SOFT: Color = (150, 157, 166)
ROBOT: Color = (38, 84, 140)
ROBOT_LIGHT: Color = (222, 234, 246)
TRAIL: Color = (128, 166, 208)
ECHO: Color = (24, 150, 160)
SPACE: Color = (214, 96, 77)
PEOPLE: tuple[Color, ...] = ((222, 135, 30), (62, 146, 101), (124, 94, 186), (200, 62, 77))
NOBODY: Color = (122, 130, 140)  # a person whose pattern is not one of the four


class Frame(NamedTuple):
    """All that a picture shows.

    Attributes:
        place: Walls and path.
        x_m: The robot's position.
        y_m: The same, other axis.
        theta_rad: Its heading.
        people: (n,) records of type ``PERSON``; those who are not present are left out.
        patterns: Index into ``PATTERN_NAMES`` for each person, or anything else for none of them.
        ranges_m: (4,) last ultrasonic readings; empty for none.
        sonar: Mounting and opening of these sensors.
        trail: (k, 2) earlier positions of the robot [m].
        radius_m: The robot's radius.
        castor_rad: Angle of the castor; not drawn if None.
        speed_mps: Actual speed.
        command_mps: Speed that the policy asked for.
        top_speed_mps: Full length of the speed bar.
        time_s: Time since the start of the episode.
        outcome: How the episode ended, or "" while it runs.
    """

    place: Place
    x_m: float
    y_m: float
    theta_rad: float
    people: Records
    patterns: Sequence[int]
    ranges_m: Floats
    sonar: Ultrasonic = Ultrasonic()
    trail: Floats = np.empty((0, 2))
    radius_m: float = 0.30
    castor_rad: float | None = None
    speed_mps: float = 0.0
    command_mps: float = 0.0
    top_speed_mps: float = 0.5
    time_s: float = 0.0
    outcome: str = ""


class View(NamedTuple):
    """Where the world lies in the picture: the point in its middle and the scale."""

    x_m: float
    y_m: float
    px_per_m: float
    width: int
    height: int

    def pixels(self, points: Floats) -> Floats:
        """Return (..., 2) pixel columns and rows of points (..., 2) [m]."""
        middle = np.array([self.width, self.height]) / 2.0
        offset = np.asarray(points) - np.array([self.x_m, self.y_m])
        return middle + self.px_per_m * offset * np.array([1.0, -1.0])


def view_of(frame: Frame, *, width: int = 960, height: int = 480) -> View:
    """Return the view of the whole path, or of the robot's surroundings where that is too far."""
    path = frame.place.path
    length = path_length(path.view(np.recarray))
    points = sample_path(path, np.linspace(0.0, length, 65))[:, :2]
    low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    scale = float(min(np.array([width, height]) / (high - low)))
    if scale < FARTHEST_PX_PER_M:
        return View(frame.x_m, frame.y_m, 1.25 * FARTHEST_PX_PER_M, width, height)
    x_m, y_m = (low + high) / 2.0
    return View(float(x_m), float(y_m), min(scale, CLOSEST_PX_PER_M), width, height)


def draw(frame: Frame, *, width: int = 960, height: int = 480) -> Image:
    """Return the picture as (height, width, 3) of uint8."""
    seen = view_of(frame, width=width, height=height)
    large = View(
        seen.x_m, seen.y_m, SMOOTHING * seen.px_per_m, SMOOTHING * width, SMOOTHING * height
    )
    canvas = _Canvas(large)
    present = [i for i, person in enumerate(frame.people) if person["status"] == PRESENT]
    people = frame.people[present]
    colors = [_color(frame.patterns[i]) for i in present]

    _draw_personal_space(canvas, people)
    _draw_place(canvas, frame)
    _draw_echoes(canvas, frame)
    for person, color in zip(people, colors, strict=True):
        _draw_person(canvas, person, color)
    _draw_robot(canvas, frame)
    _draw_legend(canvas)
    _draw_state(canvas, frame)
    return canvas.image(width, height)


class _Canvas:
    """A surface that is drawn on in metres, or in pixels of the finished picture."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.surface = pygame.Surface((view.width, view.height))
        self.surface.fill(FLOOR)
        self._layer = pygame.Surface(self.surface.get_size(), pygame.SRCALPHA)
        self._target = self.surface
        pygame.font.init()
        self._font = pygame.font.Font(None, 21 * SMOOTHING)

    def polygon(self, points: Floats, color: tuple[int, ...]) -> None:
        pygame.draw.polygon(self._target, color, self.view.pixels(points).tolist())

    def line(self, points: Floats, color: tuple[int, ...], width_m: float) -> None:
        """Draw connected lines with round ends, (n, 2) [m]."""
        pixels = self.view.pixels(points)
        width = max(round(width_m * self.view.px_per_m), SMOOTHING)
        for start, end in itertools.pairwise(pixels):
            across = np.array([start[1] - end[1], end[0] - start[0]])
            across = across / max(float(np.hypot(*across)), 1e-9) * width / 2.0
            corners = [start + across, end + across, end - across, start - across]
            pygame.draw.polygon(self._target, color, [tuple(corner) for corner in corners])
        for end in pixels:
            pygame.draw.circle(self._target, color, tuple(end), width / 2.0)

    def disc(self, x_m: float, y_m: float, radius_m: float, color: tuple[int, ...]) -> None:
        center = self.view.pixels(np.array([x_m, y_m]))
        pygame.draw.circle(self._target, color, tuple(center), radius_m * self.view.px_per_m)

    def ring(self, x_m: float, y_m: float, radius_m: float, color: tuple[int, ...]) -> None:
        center = self.view.pixels(np.array([x_m, y_m]))
        radius = radius_m * self.view.px_per_m
        pygame.draw.circle(self._target, color, tuple(center), radius, SMOOTHING)

    def bar(self, box: tuple[float, float, float, float], color: Color) -> None:
        """Draw a rounded box: left, top (negative: from the far side), width, height in pixels."""
        left, top, width, height = (value * SMOOTHING for value in box)
        top += self.view.height if top < 0.0 else 0
        left += self.view.width if left < 0.0 else 0
        pygame.draw.rect(
            self._target, color, (left, top, width, height), border_radius=int(height / 2)
        )

    def text(self, text: str, left: float, top: float, color: Color) -> float:
        """Write at a pixel (negative: from the far side) and return the width of the text."""
        ink = self._font.render(text, True, color)
        x, y = left * SMOOTHING, top * SMOOTHING
        x += self.view.width if x < 0.0 else 0
        y += self.view.height if y < 0.0 else 0
        self._target.blit(ink, (x, y))
        return float(ink.get_width() / SMOOTHING)

    def begin_layer(self) -> None:
        """Draw from now on into a transparent layer, in which later shapes replace earlier ones."""
        self._layer.fill((0, 0, 0, 0))
        self._target = self._layer

    def end_layer(self) -> None:
        """Lay the transparent layer over the picture."""
        self.surface.blit(self._layer, (0, 0))
        self._target = self.surface

    def image(self, width: int, height: int) -> Image:
        small = pygame.transform.smoothscale(self.surface, (width, height))
        pixels = np.frombuffer(pygame.image.tobytes(small, "RGB"), np.uint8)
        return pixels.reshape(height, width, 3).copy()


def _color(pattern: int) -> Color:
    return PEOPLE[pattern] if 0 <= pattern < len(PEOPLE) else NOBODY


def _placed(shape: Floats, x_m: float, y_m: float, heading_rad: float) -> Floats:
    """Return a shape (n, 2), given facing +x at the origin, where it stands and faces."""
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    return shape @ np.array([[cos, sin], [-sin, cos]]) + np.array([x_m, y_m])


def _ellipse(half_length_m: float, half_width_m: float) -> Floats:
    angles = np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)
    return np.column_stack([half_length_m * np.cos(angles), half_width_m * np.sin(angles)])


def _box(length_m: float, width_m: float, center: tuple[float, float]) -> Floats:
    corners = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]]) / 2.0
    return corners * np.array([length_m, width_m]) + np.array(center)


def _draw_personal_space(canvas: _Canvas, people: Records) -> None:
    """Shade Hall's intimate and personal zones, and outline the social one."""
    canvas.begin_layer()
    for clearance, alpha in ((PERSONAL_M, 20), (INTIMATE_M, 46)):
        for person in people:
            canvas.disc(person["x"], person["y"], person["radius"] + clearance, (*SPACE, alpha))
    for person in people:
        canvas.ring(person["x"], person["y"], person["radius"] + SOCIAL_M, (*SPACE, 34))
    canvas.end_layer()


def _draw_place(canvas: _Canvas, frame: Frame) -> None:
    length = path_length(frame.place.path.view(np.recarray))
    starts = np.arange(0.0, length, 2.0 * DASH_M)
    for start in starts:
        ends = np.array([start, min(start + DASH_M, length)])
        canvas.line(sample_path(frame.place.path, ends)[:, :2], SOFT, 0.02)
    goal_x, goal_y, *_ = sample_path(frame.place.path, np.array([length]))[0]
    canvas.disc(goal_x, goal_y, 0.09, SOFT)
    canvas.disc(goal_x, goal_y, 0.055, FLOOR)
    canvas.line(np.vstack([frame.trail, [frame.x_m, frame.y_m]]), TRAIL, 0.05)
    for x1, y1, x2, y2 in frame.place.walls:
        canvas.line(np.array([[x1, y1], [x2, y2]]), INK, 0.08)


def _draw_echoes(canvas: _Canvas, frame: Frame) -> None:
    """Fill each sensor's cone up to the first echo; without an echo it stays faint."""
    sonar = frame.sonar
    canvas.begin_layer()
    for sensor, reading in enumerate(frame.ranges_m):
        front = math.sin(sonar.front_angle_rad), math.cos(sonar.front_angle_rad)
        axis = np.array(mounting(sensor, *front))
        mounted = math.atan2(axis[1], axis[0])
        angles = np.linspace(-sonar.half_cone_rad, sonar.half_cone_rad, 13) + mounted
        rim = sonar.mount_radius_m * axis
        arc = rim + reading * np.column_stack([np.cos(angles), np.sin(angles)])
        alpha = 20 if reading >= sonar.range_m else 52
        cone = _placed(np.vstack([rim, arc]), frame.x_m, frame.y_m, frame.theta_rad)
        canvas.polygon(cone, (*ECHO, alpha))
    canvas.end_layer()


def _draw_person(canvas: _Canvas, person: Any, color: Color) -> None:
    """Draw shoulders and head from above, on the disc that counts as the body."""
    x, y, radius = float(person["x"]), float(person["y"]), float(person["radius"])
    heading = math.atan2(person["vy"], person["vx"])
    pale = tuple((3 * 255 + 2 * part) // 5 for part in color)
    dark = tuple(3 * part // 5 for part in color)
    canvas.disc(x, y, radius, pale)
    nose = np.array(
        [[0.9 * radius, 0.0], [0.3 * radius, 0.3 * radius], [0.3 * radius, -0.3 * radius]]
    )
    canvas.polygon(_placed(nose, x, y, heading), dark)
    canvas.polygon(_placed(_ellipse(0.5 * radius, radius), x, y, heading), color)
    canvas.disc(x, y, 0.42 * radius, dark)


def _draw_robot(canvas: _Canvas, frame: Frame) -> None:
    chassis, radius = Chassis(), frame.radius_m
    here = (frame.x_m, frame.y_m, frame.theta_rad)
    canvas.disc(frame.x_m, frame.y_m, radius, ROBOT)
    canvas.disc(frame.x_m, frame.y_m, radius - 0.03, ROBOT_LIGHT)
    for side in (-1.0, 1.0):
        wheel = _box(1.5 * chassis.r, 0.06, (0.0, side * chassis.L / 2.0))
        canvas.polygon(_placed(wheel, *here), INK)
    if frame.castor_rad is not None:  # drawn on the body's rim, its pivot lies further back
        castor = _placed(_box(0.10, 0.035, (-0.02, 0.0)), -0.7 * radius, 0.0, frame.castor_rad)
        canvas.polygon(_placed(castor, *here), INK)
    nose = np.array(
        [[0.8 * radius, 0.0], [0.1 * radius, 0.4 * radius], [0.1 * radius, -0.4 * radius]]
    )
    canvas.polygon(_placed(nose, *here), ROBOT)


def _draw_legend(canvas: _Canvas) -> None:
    left = 16.0
    for name, color in zip(PATTERN_NAMES, PEOPLE, strict=True):
        canvas.bar((left, -25.0, 10.0, 10.0), color)
        left += 15.0 + canvas.text(name, left + 15.0, -27.0, INK) + 14.0


def _draw_state(canvas: _Canvas, frame: Frame) -> None:
    """Write time, speed and outcome along the upper edge; the notch on the bar is the command."""
    canvas.text(f"{frame.time_s:5.1f} s", 16.0, 12.0, INK)
    length, left, top = 120.0, 84.0, 15.0
    canvas.bar((left, top, length, 8.0), (226, 228, 230))
    share = min(max(frame.speed_mps / frame.top_speed_mps, 0.0), 1.0)
    if share > 0.0:
        canvas.bar((left, top, max(share * length, 8.0), 8.0), ROBOT)
    asked = min(max(frame.command_mps / frame.top_speed_mps, 0.0), 1.0)
    canvas.bar((left + asked * (length - 3.0), top - 4.0, 3.0, 16.0), INK)
    after = left + length + 12.0
    after += canvas.text(f"{frame.speed_mps:.2f} m/s", after, 12.0, INK)
    if frame.outcome:
        good = frame.outcome == "arrived"
        canvas.text(
            frame.outcome.replace("_", " "), after + 20.0, 12.0, PEOPLE[1] if good else PEOPLE[3]
        )
