"""People estimated from the readings of a sensor ring, in the format of the tracker's fields.

Each sensor has an alpha-beta filter (Kalata 1984) of its echo's range r and of u, the approach
speed of the echo's source over ground: r' = -(u + v cos(bearing)), with v the robot's own speed.
Static objects have u = 0 for any v.

In front, an echo comes from the side wall if its range equals the range at which the cone's edge
meets the wall. Otherwise the echo is a person if its source moves, or if the range has jumped
because the source came from the side. A static source counts as a wall until it is nearer than any
wall beside a path could be. At the sides a person is nearer than the wall, and the wall is the
source at constant distance. A person who leaves a cone is extrapolated at the last speed, since the
paper's ring is blind at bearings from 30 to 75 deg. The diagonal sensors of the ring ``six`` look
there, and tell people from walls like those in front.

Not observable: speed across the line of sight, which is assumed zero; the farther of two people in
one cone; people beyond the intersection of cones and side walls; people in a blind sector; people
beside the robot at its own speed. A narrowing corridor looks like a leading person, since its range
is constant while the robot drives; therefore the robot is slow between shelves, even without
people. In a turn walls sweep through the cones, and only near echoes count as people. The paper
does not say how its robot distinguishes people from walls (A15, A16, docs/paper.md): all of this is
our choice.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.sensor_ring import PAPER, Sensors, half_cone_of, is_ahead
from hazbot_gym.core.state import PATTERN_NAMES, PERSON_RADIUS_M, Floats, Ints
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.robot import DECISION_S
from hazbot_gym.task.observation import HORIZON_S, SONAR_RANGE_M, readings

Flags = npt.NDArray[np.bool_]

ALPHA, BETA = 0.6, 0.27  # gains of r and u, critically damped: beta = 2(2 - a) - 4 sqrt(1 - a)
LEAP_M = 0.35  # a larger innovation is another source; no person approaches at 3.5 m/s
MOVING_MPS = 0.2  # almost four standard deviations of u, with the paper's noise of +-0.03 m
SETTLED = 4  # readings of one source before its u is used
WALL_M = 0.25  # tolerance of the expected wall range: tracking errors and noise
NEAR_M = 0.9  # walls 0.55 m or more beside the path never give a nearer echo in front,
NEAR_DIAGONAL_M = 0.3  # or a nearer one of a diagonal sensor
SIDE_RAD = math.radians(75.0)  # sensors at least this far from the heading look at the side walls
STEADY_S = 1.5  # a source static for this long is a wall
SIDE_WALL_M = 2.0  # farther side echoes come from an opening
CARRIED_S = 2.5  # extrapolation time without an echo
SAME_M = 0.3  # front echoes that differ by less belong to one person straight ahead
TURNING_RADPS = 0.2  # yaw rate above which walls sweep through the cones in front

SENSOR = Ultrasonic()
TO_CENTRE_M = SENSOR.mount_radius_m + PERSON_RADIUS_M  # from a range to a distance of centres


class Mounted(NamedTuple):
    """A ring as arrays (N,) over its sensors."""

    angle_rad: Floats
    side: Floats  # 1 on the left, -1 on the right
    in_front: Flags
    at_side: Flags  # the others, in front and diagonal, look along the walls
    near_m: Floats  # nearer echoes are people
    edge_rad: Floats  # of the cone, away from the heading
    wall_offset_m: Floats  # of the sensor from the path's centre line
    wall: Ints  # index of the wall on its side
    walls: Ints  # (2,) the sensors that look at the left and at the right wall


@cache
def mounted(ring: Sensors) -> Mounted:
    """Return the arrays of a ring.

    Raises:
        InvalidInput: The ring has no sensor at one of its sides.
    """
    angle_rad = np.array([sensor.angle_rad for sensor in ring])
    side = np.sign(angle_rad)
    if not {1.0, -1.0} <= set(side[np.abs(angle_rad) >= SIDE_RAD]):
        raise InvalidInput(
            "sensors.ring: people are estimated from echoes only with a sensor at each side, at "
            f"least {SIDE_RAD:.2g} rad from the heading"
        )
    in_front = np.array([is_ahead(sensor) for sensor in ring])
    at_side = np.abs(angle_rad) >= SIDE_RAD
    half_cone_rad = [half_cone_of(sensor, SENSOR.half_cone_rad) for sensor in ring]
    near_m = np.where(in_front, NEAR_M, NEAR_DIAGONAL_M)
    return Mounted(
        angle_rad=angle_rad,
        side=side,
        in_front=in_front,
        at_side=at_side,
        near_m=np.where(at_side, 0.0, near_m),
        edge_rad=np.abs(angle_rad) + half_cone_rad,
        wall_offset_m=np.array([SENSOR.mount_radius_m * math.sin(abs(a)) for a in angle_rad]),
        wall=(side < 0.0).astype(np.int64),
        walls=np.array([np.flatnonzero(at_side & (side == s))[0] for s in (1.0, -1.0)]),
    )


class Echoes(NamedTuple):
    """Filter state of each sensor's echo: arrays (..., N), in the order of the sensors."""

    range_m: Floats  # filtered, or extrapolated
    towards_mps: Floats  # u, the source's own speed towards the robot
    heard: Ints  # readings of this source so far
    steady_s: Floats  # time without motion
    is_person: Flags
    lost_s: Floats  # time of extrapolation without an echo
    side_wall_m: Floats  # (..., 2) the reading of the wall on the left and on the right


def listen(
    seen: dict[str, Floats],
    last: Echoes | None,
    starts: npt.ArrayLike | None = None,
    ring: Sensors = PAPER,
) -> Echoes:
    """Return the filter state after one more observation.

    Args:
        seen: A decoded observation, arrays (...).
        last: The previous state, or None.
        starts: (...) whether an episode has just begun.
        ring: The sensors, with one at each side.
    """
    at, readings_m = mounted(ring), readings(seen, ring)
    first = _first(readings_m, at)
    if last is None:
        return first
    update = _update(last, readings_m, seen, at)
    if starts is None:
        return update
    anew = np.asarray(starts).reshape(readings_m.shape[:-1])[..., None]
    return Echoes(*(np.where(anew, a, b) for a, b in zip(first, update, strict=True)))


def _first(readings_m: Floats, at: Mounted) -> Echoes:
    """Return the initial state: side walls, and echoes too near for a wall."""
    nothing = np.zeros_like(readings_m)
    return Echoes(
        range_m=readings_m,
        towards_mps=nothing,
        heard=np.ones(readings_m.shape, np.int64),
        steady_s=nothing,
        is_person=readings_m < at.near_m,
        lost_s=nothing,
        side_wall_m=readings_m[..., at.walls],
    )


def _update(last: Echoes, readings_m: Floats, seen: dict[str, Floats], at: Mounted) -> Echoes:
    """Return the state after one more reading of the same episode."""
    own_mps = seen["speed_mps"][..., None] * np.cos(at.angle_rad)
    predicted_m = last.range_m - (last.towards_mps + own_mps) * DECISION_S
    off_m = readings_m - predicted_m
    is_same = np.abs(off_m) <= LEAP_M
    is_carried = (off_m > LEAP_M) & last.is_person & (last.lost_s < CARRIED_S) & (predicted_m > 0.0)
    is_new = ~(is_same | is_carried)
    is_wall = ~is_carried & _is_wall(readings_m, last.side_wall_m, seen["theta_e_rad"], at)

    range_m = np.where(is_same, predicted_m + ALPHA * off_m, predicted_m)
    range_m = np.where(is_new | is_wall, readings_m, range_m)
    towards_mps = last.towards_mps - np.where(is_same, BETA / DECISION_S * off_m, 0.0)
    towards_mps = np.where(is_new | (is_wall & ~at.at_side), 0.0, towards_mps)
    heard = np.where(is_new, 1, last.heard + is_same)
    moves = (heard >= SETTLED) & (np.abs(towards_mps) > MOVING_MPS)
    steady_s = np.where(is_new | moves, 0.0, last.steady_s + DECISION_S)

    may_turn_up = (np.abs(seen["yaw_rate_radps"]) < TURNING_RADPS)[..., None]
    turns_up = may_turn_up & (moves | (off_m < -LEAP_M))
    may_be_person = ~is_wall & (at.at_side | turns_up | (last.is_person & ~is_new))
    is_person = (may_be_person & (steady_s < STEADY_S)) | is_carried | (readings_m < at.near_m)
    side_m, side_steady_s = range_m[..., at.walls], steady_s[..., at.walls]
    is_side_wall = (side_steady_s >= STEADY_S) & (side_m < SIDE_WALL_M)
    return Echoes(
        range_m=range_m,
        towards_mps=towards_mps,
        heard=heard,
        steady_s=steady_s,
        is_person=is_person,
        lost_s=np.where(is_carried, last.lost_s + DECISION_S, 0.0),
        side_wall_m=np.where(is_side_wall, side_m, last.side_wall_m),
    )


def _is_wall(readings_m: Floats, side_wall_m: Floats, theta_e_rad: Floats, at: Mounted) -> Flags:
    """Return (..., N) True for readings of the side walls, or without an echo.

    A cone's edge at the angle g to the path meets the wall, w from the rim of a robot of radius m,
    at ``(m + w - m sin(a)) / sin(g)``, with a the angle at which the sensor is mounted.
    """
    wall_m = side_wall_m[..., at.wall]
    edge_rad = np.clip(at.edge_rad + at.side * theta_e_rad[..., None], 0.1, math.pi / 2)
    edge_m = (SENSOR.mount_radius_m + wall_m - at.wall_offset_m) / np.sin(edge_rad)
    is_along = np.abs(readings_m - edge_m) < WALL_M
    is_beside = readings_m > wall_m - WALL_M
    is_nothing = readings_m > SONAR_RANGE_M - 0.1
    return np.where(at.at_side, is_beside, is_along) | is_nothing


def people(echoes: Echoes, speed_mps: Floats, ring: Sensors = PAPER) -> dict[str, Floats]:
    """Return the person fields of every sensor's echo, arrays (..., N), ``present`` if a person.

    Crossing: came from the side and neither approaches nor recedes; confronting: echo in both front
        sensors; encountering: echo in one of them; leading: recedes.

    Args:
        echoes: Filter state.
        speed_mps: (...) speed of the robot.
        ring: The sensors.
    """
    at = mounted(ring)
    u, is_person = echoes.towards_mps, echoes.is_person
    front_m = np.where(is_person, echoes.range_m, np.inf)[..., at.in_front]
    nearer_m, farther_m = front_m.min(axis=-1, keepdims=True), front_m.max(axis=-1, keepdims=True)
    is_straight = at.in_front & (farther_m < nearer_m + SAME_M)
    bearing_rad = np.where(is_straight, 0.0, at.angle_rad)
    sine, cosine = np.sin(bearing_rad), np.cos(bearing_rad)
    distance_m = np.maximum(echoes.range_m, 0.0) + TO_CENTRE_M
    time_s, closest_m = _closest_approach(distance_m, sine, cosine, u, speed_mps[..., None])
    comes, goes = u > MOVING_MPS, u < -MOVING_MPS
    is_near = (echoes.range_m < NEAR_M) & ~goes & is_straight
    patterns = {
        "crossing": ~comes & ~goes & ~is_near,
        "encountering": comes & ~is_straight,
        "leading": goes,
        "confronting": (comes & is_straight) | is_near,
    }
    return {
        "present": is_person.astype(float),
        "distance_m": distance_m,
        "bearing_sin": sine,
        "bearing_cos": cosine,
        "speed_mps": np.abs(u),
        "across_mps": np.zeros_like(u),  # not measured
        "closing_mps": u + speed_mps[..., None] * cosine,
        "time_to_closest_s": time_s,
        "closest_m": closest_m,
        **{name: (patterns[name] & ~at.at_side).astype(float) for name in PATTERN_NAMES},
    }


def _closest_approach(
    distance_m: Floats, sine: Floats, cosine: Floats, u: Floats, v: Floats
) -> tuple[Floats, Floats]:
    """Return time and distance of the closest approach, for walking along the line of sight."""
    along_mps, across_mps = u + v * cosine, v * sine  # of the relative velocity
    squared = along_mps**2 + across_mps**2
    time_s = np.maximum(along_mps, 0.0) * distance_m / np.maximum(squared, 1e-9)
    closest_m = np.hypot(distance_m - along_mps * time_s, across_mps * time_s)
    return np.minimum(time_s, HORIZON_S), closest_m
