"""Ultrasonic range sensors in closed form: first echo of a cone from discs and wall segments.

A sensor returns the distance of the nearest surface inside its cone. For discs and segments it has
a closed form, exact and cheaper than ray casting. Half cone 15 deg, 4 m, noise +-0.03 m (paper,
Table 2); directions are in ``sensor_ring``. Left out: echoes over two walls, temperature.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.geometry import nearest_on_segment
from hazbot_gym.core.jit import scalar


class Ultrasonic(NamedTuple):
    """Parameters shared by all sensors of the ring."""

    range_m: Annotated[float, Gt(0)] = 4.0  # maximum range, our choice
    half_cone_rad: Annotated[float, Gt(0), Le(1.0)] = math.radians(15.0)
    mount_radius_m: Annotated[float, Ge(0)] = 0.30  # on the rim of the body
    noise_m: Annotated[float, Ge(0)] = 0.03  # half width (paper, Table 2)
    gaussian: bool = False  # uniform as in Table 2, or Gaussian with sigma = half width / 2
    miss_angle_rad: Annotated[float, Gt(0)] = math.pi / 2  # no echo at larger incidence
    cross_talk: Annotated[float, Ge(0), Le(1)] = 0.0  # probability of hearing the mirrored sensor
    sequential: bool = False  # one sensor per decision, in turn, instead of all


class Cone(NamedTuple):
    """A sensor's cone by direction vectors, to avoid trigonometry per surface."""

    axis_x: float  # unit vector along the axis
    axis_y: float
    cos_half: float  # of the half opening angle
    sin_half: float


@scalar
def cone_at(axis_rad: float, half_cone_rad: float) -> Cone:
    """Return the cone around an axis."""
    sine, cosine = sin_cos(axis_rad)
    sin_half, cos_half = sin_cos(half_cone_rad)
    return Cone(cosine, sine, cos_half, sin_half)


@scalar
def turned(cone: Cone, sin_t: float, cos_t: float) -> Cone:
    """Rotate a cone from the robot frame by the heading t."""
    x, y = cone.axis_x, cone.axis_y
    return Cone(cos_t * x - sin_t * y, sin_t * x + cos_t * y, cone.cos_half, cone.sin_half)


@scalar
def _edge(cone: Cone, side: float) -> tuple[float, float]:
    """Return the direction of the cone's left (side 1) or right edge (side -1)."""
    sin_half = side * cone.sin_half
    return (
        cone.axis_x * cone.cos_half - cone.axis_y * sin_half,
        cone.axis_y * cone.cos_half + cone.axis_x * sin_half,
    )


@scalar
def _is_inside(x: float, y: float, distance: float, cone: Cone) -> bool:
    """Return True if a point at a distance is inside the cone; the apex is inside."""
    return x * cone.axis_x + y * cone.axis_y >= distance * cone.cos_half


@scalar
def may_meet_disc(dx: float, dy: float, radius: float, cone: Cone) -> bool:
    """Return False only if a disc is certainly outside the cone (cheap test)."""
    along = dx * cone.axis_x + dy * cone.axis_y
    across = abs(cone.axis_x * dy - cone.axis_y * dx)
    return along > -radius and across * cone.cos_half - along * cone.sin_half <= radius


@scalar
def may_meet_segment(x1: float, y1: float, x2: float, y2: float, cone: Cone) -> bool:
    """Return False only if a segment is certainly outside the cone: beyond an edge, or behind."""
    along_1, across_1 = x1 * cone.axis_x + y1 * cone.axis_y, cone.axis_x * y1 - cone.axis_y * x1
    along_2, across_2 = x2 * cone.axis_x + y2 * cone.axis_y, cone.axis_x * y2 - cone.axis_y * x2
    if along_1 < 0.0 and along_2 < 0.0:
        return False
    edge_1, edge_2 = along_1 * cone.sin_half, along_2 * cone.sin_half
    off_1, off_2 = across_1 * cone.cos_half, across_2 * cone.cos_half
    is_left = off_1 > edge_1 and off_2 > edge_2
    return not (is_left or (-off_1 > edge_1 and -off_2 > edge_2))


@scalar
def disc_echo(dx: float, dy: float, radius: float, cone: Cone) -> float:
    """Return the distance to a disc's nearest point inside the cone, or inf.

    With d = |(dx, dy)|, phi = angle between the centre and the cone's axis, alpha = half cone, the
    distance is d - r if phi <= alpha. Else the nearest point lies on the cone's edge, delta =
    phi - alpha off the centre: d cos(delta) - sqrt(r^2 - d^2 sin^2(delta)), if the edge meets the
    disc at all.

    Args:
        dx: Centre of the disc relative to the sensor [m].
        dy: The same, other axis [m].
        radius: Radius of the disc [m].
        cone: Cone of the sensor.
    """
    squared = dx * dx + dy * dy
    d = math.sqrt(squared)
    if d <= radius:
        return 0.0
    if _is_inside(dx, dy, d, cone):
        return d - radius
    side = 1.0 if cone.axis_x * dy - cone.axis_y * dx >= 0.0 else -1.0
    edge_x, edge_y = _edge(cone, side)
    along = dx * edge_x + dy * edge_y  # d cos(delta)
    half_chord_squared = radius * radius - (squared - along * along)
    if along <= 0.0 or half_chord_squared < 0.0:
        return math.inf
    return along - math.sqrt(half_chord_squared)


@scalar
def _ray_echo(x1: float, y1: float, x2: float, y2: float, cos_a: float, sin_a: float) -> float:
    """Return the distance from the origin to a segment along the ray (cos_a, sin_a), or inf."""
    sx, sy = x2 - x1, y2 - y1
    cross = cos_a * sy - sin_a * sx
    if cross == 0.0:
        return math.inf
    distance = (x1 * sy - y1 * sx) / cross
    along = (x1 * sin_a - y1 * cos_a) / cross
    return distance if distance >= 0.0 and 0.0 <= along <= 1.0 else math.inf


@scalar
def segment_echo(x1: float, y1: float, x2: float, y2: float, cone: Cone, cos_miss: float) -> float:
    """Return the distance from the origin to a segment's nearest point inside the cone, or inf.

    The nearest point is the foot of the perpendicular or an end, where these lie inside the cone,
    or else where one of the cone's edges meets the segment. A surface that is met at more than the
    miss angle from its normal reflects the pulse away (specular miss).

    Args:
        x1: Start of the segment relative to the sensor [m].
        y1: The same, other axis [m].
        x2: End of the segment [m].
        y2: The same, other axis [m].
        cone: Cone of the sensor.
        cos_miss: Cosine of the miss angle; 0 or less if nothing is missed.
    """
    near_x, near_y = nearest_on_segment(0.0, 0.0, x1, y1, x2, y2)
    distance = math.sqrt(near_x * near_x + near_y * near_y)
    if _is_inside(near_x, near_y, distance, cone):
        echo_x, echo_y = near_x, near_y
    else:
        left_x, left_y = _edge(cone, 1.0)
        right_x, right_y = _edge(cone, -1.0)
        left = _ray_echo(x1, y1, x2, y2, left_x, left_y)
        right = _ray_echo(x1, y1, x2, y2, right_x, right_y)
        distance = min(left, right)
        if distance == math.inf:
            return math.inf
        echo_x = distance * (left_x if left <= right else right_x)
        echo_y = distance * (left_y if left <= right else right_y)
    if cos_miss > 0.0 and distance > 0.0:
        sx, sy = x2 - x1, y2 - y1
        facing = abs(echo_x * sy - echo_y * sx)  # cos(incidence) |echo| |segment|
        if facing < (cos_miss - 1e-9) * distance * math.sqrt(sx * sx + sy * sy):
            return math.inf
    return distance
