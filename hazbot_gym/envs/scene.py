"""Top view of a place: floor and walls, people and their zones, the robot and its sensors."""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.kinematics import Chassis
from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, SOCIAL_M
from hazbot_gym.core.sensor_ring import half_cone_of
from hazbot_gym.core.state import PRESENT, Floats, Place, Records
from hazbot_gym.envs.canvas import (
    ECHO,
    FLOOR,
    GAS,
    INK,
    NOBODY,
    OUTSIDE,
    PEOPLE,
    ROBOT,
    SOFT,
    SPACE,
    Canvas,
    Color,
    dark,
    mixed,
    pale,
    turned,
)
from hazbot_gym.envs.frame import Frame
from hazbot_gym.envs.plume import CELL_M, PlumeGrid
from hazbot_gym.task.leak import leak_point

DASH_M = 0.15
CAPTION_PX = 18.0  # from the corner
WALL_M = 0.07  # drawn width
LEAK_M = 0.17  # half the width of its mark
DIAMOND = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
AHEAD_S = 0.35  # a person's pointer ends at the rim's predicted position
INTIMATE_ALPHA, PERSONAL_ALPHA, SOCIAL_ALPHA = 62, 28, 60
INTIMATE, PERSONAL = (mixed(SPACE, FLOOR, a / 255) for a in (INTIMATE_ALPHA, PERSONAL_ALPHA))


def draw_floor(canvas: Canvas, place: Place) -> None:
    """Draw the static floor: the dashed path and its end."""
    canvas.fill(FLOOR)
    length = path_length(place.path.view(np.recarray))
    for start in np.arange(0.0, length, 2.5 * DASH_M):
        ends = np.array([start, min(start + DASH_M, length)])
        canvas.ribbon(sample_path(place.path, ends)[:, :2], 0.02, SOFT)
    x_m, y_m, *_ = sample_path(place.path, np.array([length]))[0]
    for radius_m, color in ((0.13, INK), (0.10, FLOOR), (0.06, INK)):
        canvas.disc(x_m, y_m, radius_m, color)


def draw_walls(canvas: Canvas, frame: Frame) -> None:
    """Draw the walls and fill the unreachable area behind them."""
    canvas.fill(OUTSIDE)
    for x1, y1, x2, y2 in frame.place.walls:
        canvas.ribbon(np.array([[x1, y1], [x2, y2]]), WALL_M, INK)
    canvas.cut_out(frame.x_m, frame.y_m)


def draw_space(canvas: Canvas, people: Records) -> None:
    """Shade Hall's intimate and personal zones, and outline the social one."""
    with canvas.layer():
        for person in people:
            radius_m = float(person["radius"]) + SOCIAL_M
            canvas.ring(person["x"], person["y"], radius_m, (*SPACE, SOCIAL_ALPHA))
        for clearance_m, alpha in ((PERSONAL_M, PERSONAL_ALPHA), (INTIMATE_M, INTIMATE_ALPHA)):
            for person in people:
                radius_m = float(person["radius"]) + clearance_m
                canvas.disc(person["x"], person["y"], radius_m, (*SPACE, alpha))


def draw_plume(canvas: Canvas, frame: Frame, grid: PlumeGrid) -> None:
    """Cloud the floor where there is gas."""
    assert frame.gas is not None
    opacity = grid.opacity(frame.gas, frame.time_s)
    canvas.mist(grid.left_m, grid.top_m, CELL_M, opacity, GAS)


def draw_leak(canvas: Canvas, frame: Frame) -> None:
    """Mark the leak by a diamond."""
    assert frame.gas is not None
    x_m, y_m = leak_point(frame.place, frame.gas.record)
    for radius_m, color in ((LEAK_M, FLOOR), (LEAK_M - 0.03, INK), (LEAK_M - 0.07, GAS)):
        canvas.polygon(turned(radius_m * DIAMOND, x_m, y_m, 0.0), color)


def draw_trail(canvas: Canvas, frame: Frame) -> None:
    """Draw the robot's trail."""
    points = np.vstack([frame.trail, [frame.x_m, frame.y_m]])
    canvas.ribbon(points, 0.05, pale(ROBOT))


def draw_echoes(canvas: Canvas, frame: Frame) -> None:
    """Fill each sensor's cone up to the first echo; faint without an echo."""
    sonar = frame.sonar
    here = (frame.x_m, frame.y_m, frame.theta_rad)
    with canvas.layer():
        for sensor, reading in zip(frame.ring, frame.ranges_m, strict=False):
            half_rad, axis_rad = half_cone_of(sensor, sonar.half_cone_rad), sensor.angle_rad
            angles = axis_rad + np.linspace(-half_rad, half_rad, 13)
            rim = sonar.mount_radius_m * np.array([math.cos(axis_rad), math.sin(axis_rad)])
            arc = rim + reading * np.column_stack([np.cos(angles), np.sin(angles)])
            is_echo = reading < sonar.range_m
            cone = turned(np.vstack([rim, arc]), *here)
            canvas.polygon(cone, (*ECHO, 70 if is_echo else 30))
            if is_echo:
                canvas.ribbon(cone[1:], 0.03, (*ECHO, 230))


def draw_people(canvas: Canvas, people: Records, patterns: list[int]) -> None:
    """Draw all present people, in the colour of their pattern."""
    for person, pattern in zip(people, patterns, strict=True):
        _draw_person(canvas, person, pattern_color(pattern))


def draw_robot(canvas: Canvas, frame: Frame) -> None:
    """Draw body, driven wheels, castor and the direction of driving."""
    chassis, radius_m = Chassis(), frame.radius_m
    here = (frame.x_m, frame.y_m, frame.theta_rad)
    canvas.disc(frame.x_m, frame.y_m, radius_m, ROBOT)
    canvas.disc(frame.x_m, frame.y_m, radius_m - 0.035, (226, 238, 247))
    for side in (-1.0, 1.0):
        wheel = _box(1.5 * chassis.r, 0.06, (0.0, side * chassis.L / 2.0))
        canvas.polygon(turned(wheel, *here), INK)
    # Drawn on the body's rim, with its pivot further back; it trails outward in a turn.
    castor = turned(_box(0.12, 0.045, (-0.03, 0.0)), -0.6 * radius_m, 0.0, -frame.castor_rad)
    canvas.polygon(turned(castor, *here), INK)
    arrow = radius_m * np.array([[0.8, 0.0], [0.05, 0.42], [0.2, 0.0], [0.05, -0.42]])
    canvas.polygon(turned(arrow, *here), ROBOT)


def draw_caption(canvas: Canvas, frame: Frame) -> None:
    """Write the caption in the upper left corner."""
    if frame.caption:
        x, y, pad = CAPTION_PX, CAPTION_PX + 6.0, 10.0
        width = canvas.width_of(frame.caption) + 2.0 * pad
        canvas.box(x - pad / 2, y - 14.0, width, 28.0, FLOOR, radius=7)
        canvas.text(frame.caption, x + pad / 2, y)


def present(frame: Frame) -> tuple[Records, list[int]]:
    """Return the present people and their patterns."""
    rows = [i for i, person in enumerate(frame.people) if person["status"] == PRESENT]
    return frame.people[rows], [frame.patterns[i] for i in rows]


def pattern_color(pattern: int) -> Color:
    """Return the colour of a walking pattern."""
    return PEOPLE[pattern] if 0 <= pattern < len(PEOPLE) else NOBODY


def _draw_person(canvas: Canvas, person: np.void, color: Color) -> None:
    """Draw shoulders and head on the body's disc, and a pointer of the velocity."""
    x, y, radius_m = float(person["x"]), float(person["y"]), float(person["radius"])
    vx, vy = float(person["vx"]), float(person["vy"])
    heading_rad, tip_m = math.atan2(vy, vx), radius_m + AHEAD_S * math.hypot(vx, vy)
    pointer = np.array([[tip_m, 0.0], [0.0, 0.5 * radius_m], [0.0, -0.5 * radius_m]])
    canvas.polygon(turned(pointer, x, y, heading_rad), mixed(color, FLOOR, 0.7))
    canvas.disc(x, y, radius_m, pale(color))
    canvas.polygon(turned(_ellipse(0.5 * radius_m, radius_m), x, y, heading_rad), color)
    canvas.disc(x, y, 0.42 * radius_m, dark(color))


def _ellipse(half_length_m: float, half_width_m: float) -> Floats:
    angles = np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)
    return np.column_stack([half_length_m * np.cos(angles), half_width_m * np.sin(angles)])


def _box(length_m: float, width_m: float, center: tuple[float, float]) -> Floats:
    corners = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]]) / 2.0
    box: Floats = corners * np.array([length_m, width_m]) + np.array(center)
    return box
