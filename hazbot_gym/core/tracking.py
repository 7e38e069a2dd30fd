"""Path tracking: pose error and tracking law (paper eqs 10-12).

The paper's law (12) as printed contains neither x_e nor y_e, so that a position error persists; the
corrected law (12c) keeps its form and its three gains (A4, docs/paper.md section 3.3). The printed
law is kept for comparison. Left out: limits on speed and curvature.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Le

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.geometry import wrap_angle
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.kinematics import Pose, Twist


class TrackingGains(NamedTuple):
    """Gains of the law; negative, as the error is actual minus reference (paper section 3.3)."""

    a1: Annotated[float, Le(0)] = -1.0  # on x_e [1/s]
    a2: Annotated[float, Le(0)] = -1.2  # on v_r y_e [1/m^2]
    a3: Annotated[float, Le(0)] = -0.5  # on sin(theta_e) [1/s]


@scalar
def pose_error(pose: Pose, reference: Pose) -> Pose:
    """Return actual minus reference pose in the robot's frame, xi_e = M(theta) (xi - xi_r) (eq 10).

    The heading error is in (-pi, pi].
    """
    dx, dy = pose.x - reference.x, pose.y - reference.y
    s, c = sin_cos(pose.theta)
    return Pose(c * dx + s * dy, c * dy - s * dx, wrap_angle(pose.theta - reference.theta))


@scalar
def pose_error_rate(error: Pose, velocity: Twist, reference: Twist) -> Pose:
    """Return the time derivative of the pose error (eq 11).

    x_e' = omega y_e - v_r cos(theta_e) + v,  y_e' = -omega x_e + v_r sin(theta_e),
    theta_e' = omega - omega_r
    """
    x_e, y_e, theta_e = error
    v, omega = velocity
    v_r, omega_r = reference
    return Pose(
        omega * y_e - v_r * math.cos(theta_e) + v,
        -omega * x_e + v_r * math.sin(theta_e),
        omega - omega_r,
    )


@scalar
def tracking_law(error: Pose, reference: Twist, gains: TrackingGains) -> Twist:
    """Return the velocity of the corrected tracking law (eq 12c, docs/paper.md).

    v = v_r cos(theta_e) + a1 x_e,  omega = omega_r + a2 v_r y_e + a3 sin(theta_e).
    V = (x_e^2 + y_e^2)/2 + (1 - cos(theta_e))/|a2| then never grows.
    """
    v_r, omega_r = reference
    sine, cosine = sin_cos(error.theta)
    return Twist(
        v_r * cosine + gains.a1 * error.x,
        omega_r + gains.a2 * v_r * error.y + gains.a3 * sine,
    )


@scalar
def printed_tracking_law(
    theta_e: float, velocity_error: Twist, reference: Twist, gains: TrackingGains
) -> Twist:
    """Return the velocity of the law exactly as the paper prints it (eq 12), for comparison only.

    v = v_r cos(theta_e) + a1 v_e,  omega = omega_r + a2 v_r sin(theta_e) + a3 omega_e.

    Args:
        theta_e: Heading error [rad].
        velocity_error: v_e and omega_e, actual minus reference.
        reference: v_r and omega_r of the reference point.
        gains: The same gains as in (12c).
    """
    v_r, omega_r = reference
    return Twist(
        v_r * math.cos(theta_e) + gains.a1 * velocity_error.v,
        omega_r + gains.a2 * v_r * math.sin(theta_e) + gains.a3 * velocity_error.omega,
    )
