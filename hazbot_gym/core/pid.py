"""Wheel loop: PID control (paper eq 14) of two mismatched motors.

The paper gives no motor. Its tracking figures are reproduced by a first-order lag with wheels of
unequal strength (A11, docs/paper.md section 5.2a); the plants are fits to the published numbers,
not measurements. Left out: friction, motor current and load.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Lt

from hazbot_gym.core.geometry import clip
from hazbot_gym.core.jit import scalar


class Plant(NamedTuple):
    """Two motors, T1 dw/dt = -w + K_i u: right with K_1 = K (1 + a), left with K_2 = K (1 - a)."""

    K: Annotated[float, Gt(0)] = 2.0  # gain: wheel speed per unit of motor input [rad/s]
    T1: Annotated[float, Gt(0)] = 3.0  # time constant [s]
    T2: Annotated[float, Ge(0)] = 0.0  # extra lag between controller and motor, 0 = none [s]
    Tf: Annotated[float, Ge(0)] = 0.05  # of the filter on the derivative of the error [s]
    a: Annotated[float, Gt(-1), Lt(1)] = -0.25  # mismatch; negative: the right wheel is weaker
    u_max: Annotated[float, Ge(0)] = 0.0  # bound on |u|, 0 = none


PLANTS = {
    "A": Plant(),  # the default
    "B": Plant(T1=3.5, T2=0.1),  # closest to the paper's fuzzy-PID figures
    "A0": Plant(a=0.0),  # matched wheels
    "C": Plant(K=1.5, T1=2.0, a=-0.33),  # closest to all eight figures of the paper
}


class PidGains(NamedTuple):
    """Gains of one wheel's loop: the paper's initial values (section 3.3)."""

    kp: float = 9.0  # on the error e [rad/s]
    ki: float = 2.0  # on its integral [rad]
    kd: float = 3.0  # on its derivative [rad/s^2]


@scalar
def filtered_derivative(
    derivative: float, error: float, error_before: float, dt_s: float, Tf: float
) -> float:
    """Return the filtered derivative of the error, d += (de/dt - d) dt/(Tf + dt).

    Unfiltered, the derivative term makes a first-order motor unstable from K kd/T1 >= 1 on. The
    first sample (``error_before`` is nan) has no derivative: a jump from 0 would kick the motor and
    hide much of the error of a start from rest (plant B on the paper's circle: 0.064 instead of
    0.099 m).
    """
    rate = 0.0 if math.isnan(error_before) else (error - error_before) / dt_s
    return derivative + (rate - derivative) * dt_s / (Tf + dt_s)


@scalar
def pid_law(error: float, integral: float, derivative: float, gains: PidGains) -> float:
    """Return the motor input u = kp e + ki int(e) + kd de/dt (eq 14)."""
    return gains.kp * error + gains.ki * integral + gains.kd * derivative


@scalar
def motor_gain(plant: Plant, is_right: bool) -> float:
    """Return K_i, the gain of one of the two motors."""
    return plant.K * (1.0 + plant.a) if is_right else plant.K * (1.0 - plant.a)


@scalar
def lagged_input(drive: float, u: float, plant: Plant, dt_s: float) -> float:
    """Return the motor input, bounded and behind the extra lag, after one explicit Euler step."""
    if plant.u_max > 0.0:
        u = clip(u, -plant.u_max, plant.u_max)
    return u if plant.T2 == 0.0 else drive + (u - drive) * dt_s / plant.T2


@scalar
def motor_step(speed: float, drive: float, gain: float, T1: float, dt_s: float) -> float:
    """Return the wheel speed [rad/s] after one explicit Euler step of T1 dw/dt = -w + K_i u.

    Args:
        speed: Wheel speed w before the step [rad/s].
        drive: Motor input u behind the extra lag.
        gain: K_i of this motor.
        T1: Time constant [s].
        dt_s: Length of the step [s].
    """
    return speed + (gain * drive - speed) * dt_s / T1
