"""Kinematics of the robot: two driven front wheels and a passive castor behind (paper eqs 1-6, 13).

Frame: x forward, y left, theta counter-clockwise, origin M in the middle of the driven axle. Wheel
1 is the RIGHT one and L the full track: the paper's labels differ, its equations and numbers do not
(A1, A2, docs/paper.md). The castor follows passively and does not change the motion. Left out:
slip.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Gt

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.jit import scalar

STRAIGHT_RAD = 1e-4  # half turn of a step below which its chord is taken from the series
CASTOR_STEPS = 60  # halvings of the bracket of the castor angle: pi/2 * 2^-60 is below 1 ulp


class Chassis(NamedTuple):
    """Dimensions of the robot (paper section 2), in the paper's symbols."""

    r: Annotated[float, Gt(0)] = 0.200  # radius of a driven wheel [m]
    L: Annotated[float, Gt(0)] = 0.438  # track width [m] (A2)
    L1: Annotated[float, Gt(0)] = 0.214  # with L2: from M back to the castor's pivot [m]
    L2: Annotated[float, Gt(0)] = 0.172
    L3: Annotated[float, Gt(0)] = 0.046  # from the castor's pivot to its wheel [m]


class Pose(NamedTuple):
    """A position and a heading, or their difference in the robot's frame."""

    x: float  # [m]
    y: float  # [m]
    theta: float  # [rad]


class Twist(NamedTuple):
    """Linear velocity along the heading and yaw rate."""

    v: float  # [m/s]
    omega: float  # [rad/s]


@scalar
def body_velocity(w1: float, w2: float, chassis: Chassis) -> Twist:
    """Return the robot's velocity from its wheel speeds (eq 1).

    v = r (w1 + w2)/2,  omega = r (w1 - w2)/L

    Args:
        w1: Angular velocity of the right wheel [rad/s].
        w2: Of the left wheel [rad/s].
        chassis: Dimensions of the robot.
    """
    return Twist(0.5 * chassis.r * (w1 + w2), chassis.r * (w1 - w2) / chassis.L)


@scalar
def wheel_speeds(velocity: Twist, chassis: Chassis) -> tuple[float, float]:
    """Return the wheel speeds w1 (right), w2 (left) [rad/s] of a velocity (eq 13).

    w1 = (v + omega L/2)/r,  w2 = (v - omega L/2)/r
    """
    half = 0.5 * velocity.omega * chassis.L
    return (velocity.v + half) / chassis.r, (velocity.v - half) / chassis.r


@scalar
def turning_radius(rho: float, chassis: Chassis) -> float:
    """Return the turning radius [m], left turns positive, of a wheel ratio rho = w1/w2 (eq 4).

    R = (L/2) (rho + 1)/(rho - 1), infinite for rho = 1.
    """
    if rho == 1.0:
        return math.inf
    return 0.5 * chassis.L * (rho + 1.0) / (rho - 1.0)


@scalar
def wheel_ratio(radius_m: float, chassis: Chassis) -> float:
    """Return the wheel ratio rho = w1/w2 of a circle of radius R, left turns positive (eq 4).

    rho = (2R + L)/(2R - L); 1 for an infinite radius, infinite if the left wheel stands.
    """
    if math.isinf(radius_m):
        return 1.0
    inner = 2.0 * radius_m - chassis.L
    if inner == 0.0:
        return math.inf
    return (2.0 * radius_m + chassis.L) / inner


@scalar
def castor_reach(beta: float, chassis: Chassis) -> float:
    """Return D(beta) = L1 + L2 + L3/cos(beta) [m]: from M back to the castor's axle."""
    return chassis.L1 + chassis.L2 + chassis.L3 / math.cos(beta)


@scalar
def ratio_from_castor(beta: float, chassis: Chassis) -> float:
    """Return the wheel ratio at a castor angle beta [rad] (eq 5).

    rho = (2D + L tan(beta))/(2D - L tan(beta)), which is (4) with (6).
    """
    D = castor_reach(beta, chassis)
    lever = chassis.L * math.tan(beta)
    if lever == 2.0 * D:
        return math.inf
    return (2.0 * D + lever) / (2.0 * D - lever)


@scalar
def radius_from_castor(beta: float, chassis: Chassis) -> float:
    """Return R = D(beta)/tan(beta) [m] (eq 6 solved for R), infinite for a straight castor."""
    if beta == 0.0:
        return math.inf
    return castor_reach(beta, chassis) / math.tan(beta)


@scalar
def castor_angle(radius_m: float, chassis: Chassis) -> float:
    """Return the castor angle beta in (-pi/2, pi/2) [rad] of a turning radius (eq 6).

    tan(beta) = D(beta)/R is implicit. R sin(beta) - (L1 + L2) cos(beta) - L3 is negative at 0 and,
    for R > L3, positive at pi/2, with one root between, which is bracketed by halving. Radii up to
    L3 would put the castor's wheel across the centre of the turn: it then stands at pi/2.
    """
    if math.isinf(radius_m):
        return 0.0
    R = abs(radius_m)
    low, high = 0.0, 0.5 * math.pi
    for _ in range(CASTOR_STEPS):
        beta = 0.5 * (low + high)
        if R * math.sin(beta) - (chassis.L1 + chassis.L2) * math.cos(beta) < chassis.L3:
            low = beta
        else:
            high = beta
    return math.copysign(0.5 * (low + high), radius_m)


@scalar
def arc_step(pose: Pose, velocity: Twist, dt_s: float) -> Pose:
    """Return the pose after driving with a constant velocity: eqs 2 and 3 integrated exactly.

    With the half turn h = omega dt/2 the chord is v dt sin(h)/h long and points along theta + h.
    The heading is not wrapped.
    """
    h = 0.5 * velocity.omega * dt_s
    shortening = sin_cos(h)[0] / h if abs(h) > STRAIGHT_RAD else 1.0 - h * h / 6.0
    chord = velocity.v * dt_s * shortening
    sine, cosine = sin_cos(pose.theta + h)
    return Pose(pose.x + chord * cosine, pose.y + chord * sine, pose.theta + 2.0 * h)
