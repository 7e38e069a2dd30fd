"""Vectorized drive: each field of robot and wheels is an array over lanes (robots).

The batched engine fills all lanes with different worlds, the reference engine a single lane. Lanes
are independent. The loops over lanes compile to vector instructions, four lanes at a time: no
calls, no branches that differ between lanes, parameters as values instead of records. Code that
cannot be vectorized, curves and the gain table, has separate loops.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.fuzzy_pid import FuzzyPid, fuzzy_pid_gains
from hazbot_gym.core.geometry import STRAIGHT_PER_M, clip, path_length, path_pose, piece_at
from hazbot_gym.core.jit import LANES, routine, scalar
from hazbot_gym.core.kinematics import Chassis, Pose, Twist, arc_step, body_velocity, wheel_speeds
from hazbot_gym.core.line_sensor import LineSensor, seen_offset
from hazbot_gym.core.noise import WHEELS, uniform4
from hazbot_gym.core.pid import (
    PidGains,
    Plant,
    filtered_derivative,
    lagged_input,
    motor_gain,
    motor_step,
    pid_law,
)
from hazbot_gym.core.state import LEFT, RIGHT, WHEEL, Floats, Ints, Records, RobotRecord
from hazbot_gym.core.tracking import TrackingGains, pose_error, tracking_law

_EACH, _EACH_WHEEL = ("f8", (LANES,)), ("f8", (2, LANES))
DRIVE_LANES = np.dtype(
    [
        *((name, *_EACH) for name in ("command", "v_ref", "s", "x", "y", "theta", "v", "omega")),
        ("y_seen", *_EACH),
        *((name, *_EACH) for name in ("x_r", "y_r", "theta_r", "curvature")),  # reference pose
        *((name, *_EACH) for name in ("x_0", "y_0", "s_0", "cos", "sin")),  # its line
        ("is_straight", "i8", (LANES,)),
        ("heading_noise", *_EACH),
        ("key", "u8", (LANES,)),
        ("step", "i8", (LANES,)),
        *((name, *_EACH_WHEEL) for name in ("wanted", "noise", "kp", "ki", "kd")),
        *((name, *_EACH_WHEEL) for name in WHEEL.names or ()),
    ],
    align=True,
)  # fields of ROBOT and WHEEL as arrays over lanes, and scratch fields of a step


class DriveLanes(Protocol):
    """One element of an array of ``DRIVE_LANES``; all fields are arrays over lanes."""

    command: Floats
    v_ref: Floats
    s: Floats
    x: Floats
    y: Floats
    theta: Floats
    v: Floats
    omega: Floats
    y_seen: Floats
    x_r: Floats
    y_r: Floats
    theta_r: Floats
    curvature: Floats
    x_0: Floats
    y_0: Floats
    s_0: Floats
    cos: Floats
    sin: Floats
    is_straight: Ints
    heading_noise: Floats
    key: npt.NDArray[np.uint64]
    step: Ints
    wanted: Floats
    noise: Floats
    kp: Floats
    ki: Floats
    kd: Floats
    speed: Floats
    drive: Floats
    integral: Floats
    error: Floats
    derivative: Floats


FUZZY_PID, PID, IDEAL = 0, 1, 2


class DriveParameters(NamedTuple):
    """The ``drive`` section of the config as numbers; ``as_record`` converts it for kernels."""

    dt_s: float  # physics step [s]
    nominal_speed_mps: float
    acceleration_mps2: float
    deceleration_mps2: float
    wheel_loop: int  # FUZZY_PID, PID or IDEAL
    wheel_noise_radps: float
    heading_noise_rad: float
    chassis: Chassis
    tracking: TrackingGains
    plant: Plant
    pid: PidGains
    fuzzy: FuzzyPid
    line: LineSensor


@scalar
def drive_values(p: DriveParameters) -> DriveParameters:
    """Return the parameters as values, which the compiler can keep in registers."""
    chassis, plant = p.chassis, p.plant
    return DriveParameters(
        p.dt_s, p.nominal_speed_mps, p.acceleration_mps2, p.deceleration_mps2, p.wheel_loop,
        p.wheel_noise_radps, p.heading_noise_rad,
        Chassis(chassis.r, chassis.L, chassis.L1, chassis.L2, chassis.L3),
        TrackingGains(p.tracking.a1, p.tracking.a2, p.tracking.a3),
        Plant(plant.K, plant.T1, plant.T2, plant.Tf, plant.a, plant.u_max),
        PidGains(p.pid.kp, p.pid.ki, p.pid.kd),
        FuzzyPid(
            p.fuzzy.error_scale, p.fuzzy.rate_scale,
            p.fuzzy.kp_span, p.fuzzy.ki_span, p.fuzzy.kd_span, p.fuzzy.sign,
        ),
        LineSensor(p.line.pitch_m, p.line.line_m),
    )  # fmt: skip


# --- in and out ----------------------------------------------------------------------------------


@scalar
def load_lane(
    lanes: DriveLanes, i: int, robot: RobotRecord, wheels: Records, key: np.uint64, step: int
) -> None:
    """Load a robot and its wheels into lane i.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        i: Index of the lane.
        robot: Record of type ``ROBOT``.
        wheels: (2,) records of type ``WHEEL``.
        key: Key of the scenario's noise.
        step: Physics steps since the start of the episode.
    """
    lanes.key[i], lanes.step[i] = key, step
    lanes.command[i], lanes.v_ref[i], lanes.s[i] = robot.obeyed, robot.v_ref, robot.s
    lanes.y_seen[i] = robot.y_seen
    lanes.x[i], lanes.y[i], lanes.theta[i] = robot.x, robot.y, robot.theta
    for w in (RIGHT, LEFT):
        wheel = wheels[w]
        lanes.speed[w, i], lanes.drive[w, i], lanes.integral[w, i] = (
            wheel.speed,
            wheel.drive,
            wheel.integral,
        )
        lanes.error[w, i], lanes.derivative[w, i] = wheel.error, wheel.derivative


@scalar
def store_lane(lanes: DriveLanes, i: int, robot: RobotRecord, wheels: Records) -> None:
    """Store lane i to its robot and wheels, after at least one step."""
    robot.v_ref, robot.s, robot.y_seen = lanes.v_ref[i], lanes.s[i], lanes.y_seen[i]
    robot.x, robot.y, robot.theta = lanes.x[i], lanes.y[i], lanes.theta[i]
    robot.v, robot.omega = lanes.v[i], lanes.omega[i]
    for w in (RIGHT, LEFT):
        wheel = wheels[w]
        wheel.speed, wheel.drive, wheel.integral = (
            lanes.speed[w, i],
            lanes.drive[w, i],
            lanes.integral[w, i],
        )
        wheel.error, wheel.derivative = lanes.error[w, i], lanes.derivative[w, i]


@scalar
def aim_lane(lanes: DriveLanes, i: int, path: Records, reach_m: float) -> None:
    """Set the line of lane i's reference point, if it stays on a straight piece for a while.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        i: Index of the lane.
        path: (M,) records of type ``PATH_PIECE``.
        reach_m: Distance until the lane is aimed again [m].
    """
    piece = path[piece_at(path, lanes.s[i])]
    is_last = piece.s + piece.length >= path_length(path)
    is_within = is_last or lanes.s[i] + reach_m < piece.s + piece.length
    lanes.is_straight[i] = abs(piece.curvature) < STRAIGHT_PER_M and is_within
    lanes.x_0[i], lanes.y_0[i], lanes.s_0[i] = piece.x, piece.y, piece.s
    lanes.cos[i], lanes.sin[i] = piece.cos, piece.sin
    lanes.theta_r[i], lanes.curvature[i] = piece.heading, 0.0


@scalar
def follow_lane(lanes: DriveLanes, i: int, path: Records) -> None:
    """Compute lane i's reference pose on a piece that is not straight."""
    if not lanes.is_straight[i]:
        lanes.x_r[i], lanes.y_r[i], lanes.theta_r[i], lanes.curvature[i] = path_pose(
            path, lanes.s[i]
        )


@scalar
def follow_lines(lanes: DriveLanes) -> None:
    """Compute the reference poses of all lanes on straight pieces; ``follow_lane`` for others.

    Equivalent to ``path_pose`` on a line.
    """
    for i in range(LANES):
        along = lanes.s[i] - lanes.s_0[i]
        lanes.x_r[i] = lanes.x_0[i] + along * lanes.cos[i]
        lanes.y_r[i] = lanes.y_0[i] + along * lanes.sin[i]


# --- one physics step ----------------------------------------------------------------------------


@scalar
def slew(speed_mps: float, command_mps: float, p: DriveParameters) -> float:
    """Return the slew-limited reference speed one physics step later [m/s]."""
    change = command_mps - speed_mps
    return speed_mps + clip(change, -p.deceleration_mps2 * p.dt_s, p.acceleration_mps2 * p.dt_s)


@scalar
def measurement_noise(p: DriveParameters, key: np.uint64, step: int) -> tuple[float, float, float]:
    """Return the errors of right and left wheel speed [rad/s] and of heading [rad] at a step."""
    right, left, heading, _ = uniform4(key, WHEELS, step, 0)
    return (
        (2.0 * right - 1.0) * p.wheel_noise_radps,
        (2.0 * left - 1.0) * p.wheel_noise_radps,
        (2.0 * heading - 1.0) * p.heading_noise_rad,
    )


@scalar
def loop_gains(error: float, derivative: float, p: DriveParameters, gain_table: Floats) -> PidGains:
    """Return the gains of a wheel loop for its present error: fuzzy (15) or fixed."""
    if p.wheel_loop == FUZZY_PID:
        return fuzzy_pid_gains(error, derivative, p.pid, p.fuzzy, gain_table)
    return PidGains(p.pid.kp, p.pid.ki, p.pid.kd)


@scalar
def _disturb(lanes: DriveLanes, p: DriveParameters) -> None:
    """Draw the measurement noise of a step."""
    for i in range(LANES):
        right, left, heading = measurement_noise(p, lanes.key[i], lanes.step[i])
        lanes.noise[RIGHT, i], lanes.noise[LEFT, i], lanes.heading_noise[i] = right, left, heading
        lanes.step[i] += 1


@scalar
def _steer(lanes: DriveLanes, p: DriveParameters) -> None:
    """Advance the reference speeds, and compute the wheel speeds that track them."""
    for i in range(LANES):
        _ask_wheels(lanes, i, _measured_error(lanes, i), p)


@scalar
def _steer_by_line(lanes: DriveLanes, p: DriveParameters) -> None:
    """Do the same, with the cross-track error of the line sensor."""
    for i in range(LANES):
        error = _measured_error(lanes, i)
        lanes.y_seen[i] = seen_offset(error.y, lanes.y_seen[i], p.line)
        _ask_wheels(lanes, i, Pose(error.x, lanes.y_seen[i], error.theta), p)


@scalar
def _measured_error(lanes: DriveLanes, i: int) -> Pose:
    """Return the pose error with heading noise."""
    measured = Pose(lanes.x[i], lanes.y[i], lanes.theta[i] + lanes.heading_noise[i])
    return pose_error(measured, Pose(lanes.x_r[i], lanes.y_r[i], lanes.theta_r[i]))


@scalar
def _ask_wheels(lanes: DriveLanes, i: int, error: Pose, p: DriveParameters) -> None:
    """Compute the desired wheel speeds from a pose error."""
    v_ref = slew(lanes.v_ref[i], lanes.command[i], p)
    velocity = tracking_law(error, Twist(v_ref, v_ref * lanes.curvature[i]), p.tracking)
    w1, w2 = wheel_speeds(velocity, p.chassis)
    lanes.v_ref[i], lanes.wanted[RIGHT, i], lanes.wanted[LEFT, i] = v_ref, w1, w2


@scalar
def _measure(lanes: DriveLanes, w: int, p: DriveParameters) -> None:
    """Compute the control errors of the wheels on one side."""
    for i in range(LANES):
        error = lanes.wanted[w, i] - (lanes.speed[w, i] + lanes.noise[w, i])
        lanes.derivative[w, i] = filtered_derivative(
            lanes.derivative[w, i], error, lanes.error[w, i], p.dt_s, p.plant.Tf
        )
        lanes.error[w, i] = error
        lanes.integral[w, i] += error * p.dt_s


@scalar
def _turn(lanes: DriveLanes, w: int, p: DriveParameters) -> None:
    """Step the motors on one side."""
    gain = motor_gain(p.plant, w == RIGHT)
    for i in range(LANES):
        gains = PidGains(lanes.kp[w, i], lanes.ki[w, i], lanes.kd[w, i])
        u = pid_law(lanes.error[w, i], lanes.integral[w, i], lanes.derivative[w, i], gains)
        drive = lagged_input(lanes.drive[w, i], u, p.plant, p.dt_s)
        lanes.speed[w, i] = motor_step(lanes.speed[w, i], drive, gain, p.plant.T1, p.dt_s)
        lanes.drive[w, i] = drive


@scalar
def _roll(lanes: DriveLanes, p: DriveParameters) -> None:
    """Integrate the poses of the robots, and advance the reference points."""
    for i in range(LANES):
        actual = body_velocity(lanes.speed[RIGHT, i], lanes.speed[LEFT, i], p.chassis)
        pose = arc_step(Pose(lanes.x[i], lanes.y[i], lanes.theta[i]), actual, p.dt_s)
        lanes.v[i], lanes.omega[i] = actual.v, actual.omega
        lanes.x[i], lanes.y[i], lanes.theta[i] = pose.x, pose.y, pose.theta
        lanes.s[i] += lanes.v_ref[i] * p.dt_s


@routine
def drive_step(lanes: DriveLanes, p: DriveParameters, gain_table: Floats) -> None:
    """Advance all lanes by one physics step; requires current reference poses.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        p: From ``drive_values``.
        gain_table: From ``core.fuzzy_pid.gain_table``.
    """
    if p.wheel_noise_radps > 0.0 or p.heading_noise_rad > 0.0:
        _disturb(lanes, p)
    if p.line.pitch_m > 0.0:
        _steer_by_line(lanes, p)
    else:
        _steer(lanes, p)
    for w in (RIGHT, LEFT):
        if p.wheel_loop == IDEAL:
            for i in range(LANES):
                lanes.speed[w, i] = lanes.wanted[w, i]
            continue
        _measure(lanes, w, p)
        for i in range(LANES):
            lanes.kp[w, i], lanes.ki[w, i], lanes.kd[w, i] = loop_gains(
                lanes.error[w, i], lanes.derivative[w, i], p, gain_table
            )
        _turn(lanes, w, p)
    _roll(lanes, p)


@scalar
def drive_alone(
    lanes: DriveLanes, i: int, path: Records, p: DriveParameters, table: Floats
) -> None:
    """Advance the robot in lane i alone by one physics step on its path."""
    aim_lane(lanes, i, path, p.nominal_speed_mps * p.dt_s)
    follow_lines(lanes)
    follow_lane(lanes, i, path)
    drive_step(lanes, p, table)
