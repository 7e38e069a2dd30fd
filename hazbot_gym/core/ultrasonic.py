"""Ultrasonic range sensors in closed form: the first echo of a cone among discs and wall segments.

An ultrasonic sensor answers with the distance of the nearest surface inside its cone. Against a
disc or a segment that distance has a closed form, exact and far cheaper than a bundle of rays.
Mounting: two in front at +-15 deg, one on each side (paper, section 2; SPEC section 4.2); half cone
15 deg, 4 m, noise +-0.03 m (SPEC section 6). Left out: echoes over two walls, temperature.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from hazbot_gym.core.geometry import clip, nearest_on_segment, wrap_angle
from hazbot_gym.core.jit import scalar

FRONT_LEFT, FRONT_RIGHT, SIDE_LEFT, SIDE_RIGHT = 0, 1, 2, 3
SENSOR_NAMES = ("front_left", "front_right", "left", "right")


class Ultrasonic(NamedTuple):
    """Four identical sensors on the rim of the robot."""

    range_m: Annotated[float, Gt(0)] = 4.0  # farthest echo (SPEC 4.2)
    half_cone_rad: Annotated[float, Gt(0), Le(1.0)] = math.radians(15.0)  # (SPEC 4.2)
    front_angle_rad: Annotated[float, Ge(0), Le(1.5)] = math.radians(15.0)  # (SPEC 4.2)
    mount_radius_m: Annotated[float, Ge(0)] = 0.30  # on the rim of the body
    noise_m: Annotated[float, Ge(0)] = 0.03  # half width (SPEC section 6, Table 2)
    gaussian: bool = False  # uniform as in Table 2, or Gaussian with sigma = half width / 2
    miss_angle_rad: Annotated[float, Gt(0)] = math.pi / 2  # walls hit more slantingly give no echo
    cross_talk: Annotated[float, Ge(0), Le(1)] = 0.0  # chance of the neighbour's nearer echo
    sequential: bool = False  # one sensor a decision, in turn, instead of all at once


@scalar
def mounting_angle(sensor: int, front_angle_rad: float) -> float:
    """Return the direction of a sensor's axis in the robot frame [rad]."""
    if sensor == FRONT_LEFT:
        return front_angle_rad
    if sensor == FRONT_RIGHT:
        return -front_angle_rad
    return math.pi / 2 if sensor == SIDE_LEFT else -math.pi / 2


@scalar
def disc_echo(dx: float, dy: float, radius: float, axis_rad: float, half_cone_rad: float) -> float:
    """Return the distance to a disc's nearest point inside the cone, or inf.

    With d = |(dx, dy)|, phi = angle between the centre and the cone's axis, alpha = half cone, the
    distance is d - r if phi <= alpha. Else the nearest point lies on the cone's edge, delta =
    phi - alpha off the centre: d cos(delta) - sqrt(r^2 - d^2 sin^2(delta)), if the edge meets the
    disc at all.

    Args:
        dx: Centre of the disc relative to the sensor [m].
        dy: The same, other axis [m].
        radius: Radius of the disc [m].
        axis_rad: Direction of the cone's axis.
        half_cone_rad: Half opening angle.
    """
    d = math.hypot(dx, dy)
    if d <= radius:
        return 0.0
    delta = abs(wrap_angle(math.atan2(dy, dx) - axis_rad)) - half_cone_rad
    if delta <= 0.0:
        return d - radius
    miss = d * math.sin(delta)
    if delta >= math.pi / 2 or miss > radius:
        return math.inf
    return d * math.cos(delta) - math.sqrt(radius * radius - miss * miss)


@scalar
def _ray_echo(x1: float, y1: float, x2: float, y2: float, angle_rad: float) -> float:
    """Return the distance from the origin to a segment along a ray, or inf."""
    cos_a, sin_a = math.cos(angle_rad), math.sin(angle_rad)
    sx, sy = x2 - x1, y2 - y1
    cross = cos_a * sy - sin_a * sx
    if cross == 0.0:
        return math.inf
    distance = (x1 * sy - y1 * sx) / cross
    along = (x1 * sin_a - y1 * cos_a) / cross
    return distance if distance >= 0.0 and 0.0 <= along <= 1.0 else math.inf


@scalar
def _is_in_cone(x: float, y: float, axis_rad: float, half_cone_rad: float) -> bool:
    return abs(wrap_angle(math.atan2(y, x) - axis_rad)) <= half_cone_rad


@scalar
def segment_echo(
    x1: float, y1: float, x2: float, y2: float, axis_rad: float, sensor: Ultrasonic
) -> float:
    """Return the distance from the origin to a segment's nearest point inside the cone, or inf.

    The nearest point is the foot of the perpendicular or an end, where these lie inside the cone,
    or else where one of the cone's edges meets the segment. A surface that is met at more than
    ``miss_angle_rad`` from its normal reflects the pulse away (specular miss).

    Args:
        x1: Start of the segment relative to the sensor [m].
        y1: The same, other axis [m].
        x2: End of the segment [m].
        y2: The same, other axis [m].
        axis_rad: Direction of the cone's axis.
        sensor: The sensor's parameters.
    """
    alpha = sensor.half_cone_rad
    near_x, near_y = nearest_on_segment(0.0, 0.0, x1, y1, x2, y2)
    if _is_in_cone(near_x, near_y, axis_rad, alpha):
        echo_x, echo_y = near_x, near_y
        distance = math.hypot(near_x, near_y)
    else:
        left = _ray_echo(x1, y1, x2, y2, axis_rad + alpha)
        right = _ray_echo(x1, y1, x2, y2, axis_rad - alpha)
        distance = min(left, right)
        edge = axis_rad + alpha if left <= right else axis_rad - alpha
        if distance == math.inf:
            return math.inf
        echo_x, echo_y = distance * math.cos(edge), distance * math.sin(edge)
    length = math.hypot(x2 - x1, y2 - y1)
    if distance > 0.0 and length > 0.0:
        cross = abs(echo_x * (y2 - y1) - echo_y * (x2 - x1)) / (distance * length)
        incidence = math.acos(clip(cross, 0.0, 1.0))  # between the pulse and the wall's normal
        if incidence > sensor.miss_angle_rad + 1e-9:
            return math.inf
    return distance
