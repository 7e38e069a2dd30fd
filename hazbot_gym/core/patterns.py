"""Classification of the paper's walking patterns from relative geometry.

The paper names four patterns (crossing, encountering, leading, confronting) without a definition.
Here they follow from heading difference, bearing, and miss distance at constant velocities.
Patterns in real tracks are counted by the same definition (task/pattern_events.py), with walking
side by side as a fifth pattern. Standing people are not in those counts, but have a separate rule.

Left out: curved paths, groups, and memory; the tracker holds a label over time.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt

from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import (
    BESIDE,
    CONFRONTING,
    CROSSING,
    ENCOUNTERING,
    LEADING,
    NO_PATTERN,
)


class Thresholds(NamedTuple):
    """Thresholds between patterns: our choices, the same as in the track counts."""

    front_rad: Annotated[float, Gt(0)] = math.radians(90.0)  # largest bearing, to each side
    aligned_rad: Annotated[float, Gt(0)] = math.radians(45.0)  # headings alike; bearing "ahead"
    opposed_rad: Annotated[float, Gt(0)] = math.radians(135.0)  # headings opposite
    moving_mps: Annotated[float, Ge(0)] = 0.3  # slower than this is standing
    # Head-on pairs in corridors pass at a median of 0.56 to 0.78 m; 0.5 m is robot plus person.
    head_on_m: Annotated[float, Ge(0)] = 0.6


@scalar
def closest_approach(px: float, py: float, vx: float, vy: float) -> tuple[float, float]:
    """Return time [s] and distance [m] of the closest approach at constant velocity.

    t = max(0, -p.v / |v|^2),  d = |p + v t|; without relative motion that is now: t = 0, d = |p|.

    Args:
        px: Position of the other relative to oneself [m].
        py: The same, other axis [m].
        vx: Velocity of the other relative to oneself [m/s].
        vy: The same, other axis [m/s].
    """
    squared = vx * vx + vy * vy
    time_s = 0.0
    if squared > 0.0:
        time_s = max(0.0, -(px * vx + py * vy) / squared)
    return time_s, norm(px + vx * time_s, py + vy * time_s)


@scalar
def classify_walking(
    px: float, py: float, theta: float, speed: float, vx: float, vy: float, thresholds: Thresholds
) -> int:
    """Return the pattern of a person walking in front of a moving robot, else NO_PATTERN.

    Headings within 45 deg: LEADING if ahead, else BESIDE. Headings 135 deg apart or more, and
    closing: CONFRONTING if the constant-velocity miss distance is at most 0.6 m, else ENCOUNTERING.
    Between, and closing: CROSSING.

    Args:
        px: Position of the person relative to the robot, world axes [m].
        py: The same, other axis [m].
        theta: Heading of the robot [rad].
        speed: Its speed; the intended speed to keep labels of a stopped robot [m/s].
        vx: Velocity of the person, world axes [m/s].
        vy: The same, other axis [m/s].
        thresholds: Thresholds between patterns.
    """
    both_move = speed > thresholds.moving_mps and norm(vx, vy) > thresholds.moving_mps
    ahead, left = _in_robot_frame(px, py, theta)
    bearing = abs(math.atan2(left, ahead))
    if not both_move or bearing > thresholds.front_rad:
        return NO_PATTERN
    v_ahead, v_left = _in_robot_frame(vx, vy, theta)
    turn = abs(math.atan2(v_left, v_ahead))
    if turn <= thresholds.aligned_rad:
        return LEADING if bearing <= thresholds.aligned_rad else BESIDE
    if ahead * (v_ahead - speed) + left * v_left >= 0.0:
        return NO_PATTERN
    if turn < thresholds.opposed_rad:
        return CROSSING
    miss = closest_approach(ahead, left, v_ahead - speed, v_left)[1]
    return CONFRONTING if miss <= thresholds.head_on_m else ENCOUNTERING


@scalar
def classify_standing(px: float, py: float, theta: float, thresholds: Thresholds) -> int:
    """Return the pattern of a person standing in front of the robot, else NO_PATTERN.

    Standing in the robot's way is CONFRONTING, beside its way ENCOUNTERING.
    The arguments are those of ``classify_walking``.
    """
    ahead, left = _in_robot_frame(px, py, theta)
    if abs(math.atan2(left, ahead)) > thresholds.front_rad:
        return NO_PATTERN
    return CONFRONTING if abs(left) <= thresholds.head_on_m else ENCOUNTERING


@scalar
def classify(
    px: float, py: float, theta: float, speed: float, vx: float, vy: float, thresholds: Thresholds
) -> int:
    """Return the pattern of a walking or standing person in front of the robot, else NO_PATTERN.

    The arguments are those of ``classify_walking``.
    """
    if norm(vx, vy) <= thresholds.moving_mps:
        return classify_standing(px, py, theta, thresholds)
    return classify_walking(px, py, theta, speed, vx, vy, thresholds)


@scalar
def _in_robot_frame(x: float, y: float, theta: float) -> tuple[float, float]:
    """Return the components ahead and to the left of a vector in world axes."""
    c, s = math.cos(theta), math.sin(theta)
    return x * c + y * s, y * c - x * s
