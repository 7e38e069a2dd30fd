"""Behaviour of the printed tracking law (eq 12), compared with the corrected law (12c).

Equation 12 has velocity errors where (12c) has pose errors, and does not say how they are measured.
Each reading is run over a lap, with the wheel loops of plant A.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.kinematics import Pose, Twist, arc_step, body_velocity, wheel_speeds
from hazbot_gym.core.pid import (
    filtered_derivative,
    lagged_input,
    motor_gain,
    motor_step,
    pid_law,
)
from hazbot_gym.core.state import (
    LEFT,
    RIGHT,
    WHEEL,
    Floats,
    Records,
    WheelRecord,
    as_record,
    records,
)
from hazbot_gym.core.tracking import (
    TrackingGains,
    pose_error,
    pose_error_rate,
    printed_tracking_law,
    tracking_law,
)
from hazbot_gym.paper.sections.circle.experiment import PHYSICS_S, paper_drive
from hazbot_gym.sim.drive import drive_parameters
from hazbot_gym.sim.lanes import DriveParameters, drive_values, loop_gains
from hazbot_gym.task.places import CIRCLE_RADIUS_M

LAWS = {
    "(12c)": "corrected: x_e and v_r y_e",
    "measured": "(12) with v_e = v - v_r, omega_e = omega - omega_r of the last step",
    "rates": "(12) with v_e = x_e', omega_e = theta_e'",
    "positions": "(12) with x_e for v_e and theta_e for omega_e",
}
CORRECTED, MEASURED, RATES = range(3)  # the last one is measured


class Left(NamedTuple):
    """Remaining errors at the end of a lap; infinite if diverged."""

    position_m: float
    angle_rad: float


@scalar
def _wanted(
    law: int, error: Pose, velocity: Twist, reference: Twist, gains: TrackingGains
) -> Twist:
    """Return the velocity of a reading of the law."""
    if law == CORRECTED:
        return tracking_law(error, reference, gains)
    if law == MEASURED:
        away = Twist(velocity.v - reference.v, velocity.omega - reference.omega)
    elif law == RATES:
        rate = pose_error_rate(error, velocity, reference)
        away = Twist(rate.x, rate.theta)
    else:
        away = Twist(error.x, error.theta)
    return printed_tracking_law(error.theta, away, reference, gains)


@lean_kernel
def _final_error(
    law: int, radius_m: float, steps: int, wheels: Records, parameters: Records, table: Floats
) -> tuple[float, float]:
    p = drive_values(parameters[0])
    reference = Twist(p.nominal_speed_mps, p.nominal_speed_mps / radius_m)
    pose, target, velocity = Pose(0.0, 0.0, 0.0), Pose(0.0, 0.0, 0.0), Twist(0.0, 0.0)
    error = Pose(0.0, 0.0, 0.0)
    for _ in range(steps):
        error = pose_error(pose, target)
        speeds = wheel_speeds(_wanted(law, error, velocity, reference, p.tracking), p.chassis)
        for w in (RIGHT, LEFT):
            _turn(wheels[w], speeds[w], w == RIGHT, p, table)
        velocity = body_velocity(wheels[RIGHT].speed, wheels[LEFT].speed, p.chassis)
        pose = arc_step(pose, velocity, p.dt_s)
        target = arc_step(target, reference, p.dt_s)
    error = pose_error(pose, target)
    return math.sqrt(error.x * error.x + error.y * error.y), abs(error.theta)


@scalar
def _turn(
    wheel: WheelRecord, wanted_radps: float, is_right: bool, p: DriveParameters, table: Floats
) -> None:
    """Step a wheel's loop and motor; scalar version of ``sim/lanes.py``."""
    error = wanted_radps - wheel.speed
    wheel.derivative = filtered_derivative(wheel.derivative, error, wheel.error, p.dt_s, p.plant.Tf)
    wheel.error = error
    wheel.integral += error * p.dt_s
    gains = loop_gains(error, wheel.derivative, p, table)
    u = pid_law(error, wheel.integral, wheel.derivative, gains)
    wheel.drive = lagged_input(wheel.drive, u, p.plant, p.dt_s)
    gain = motor_gain(p.plant, is_right)
    wheel.speed = motor_step(wheel.speed, wheel.drive, gain, p.plant.T1, p.dt_s)


def left_over(law: str, plant: str = "A") -> Left:
    """Return the remaining errors after a lap with one of the ``LAWS``."""
    wheels = records(WHEEL, 2)
    wheels["error"] = np.nan
    drive = paper_drive(plant=plant)
    steps = int(2.0 * math.pi * CIRCLE_RADIUS_M / drive.nominal_speed_mps / PHYSICS_S)
    parameters = as_record(drive_parameters(drive, PHYSICS_S))
    position, angle = _final_error(
        list(LAWS).index(law), CIRCLE_RADIUS_M, steps, wheels, parameters, gain_table(drive.tables)
    )
    is_finite = math.isfinite(position) and position < 2.0 * CIRCLE_RADIUS_M
    return Left(position, angle) if is_finite else Left(math.inf, math.inf)
