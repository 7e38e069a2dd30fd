"""The execution layer: from a commanded speed to the robot's motion along its path.

Once every physics step: slew limit -> reference point on the path -> tracking law (12c) -> wheel
speeds (13) -> wheel loops (14, 15) on mismatched motors -> pose (1-3). The order of the steps is
that of SPEC section 5, whose figures it reproduces. Left out: slip, steering by the policy.

Robots are driven side by side, in lanes, each field an array over lanes: the batched engine fills
all lanes with different worlds, the reference engine one of them. No lane knows of another.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hazbot_gym.core.fuzzy_pid import FuzzyPid, fuzzy_pid_gains
from hazbot_gym.core.geometry import STRAIGHT_PER_M, clip, path_length, path_pose, piece_at
from hazbot_gym.core.jit import LANES, kernel, routine, scalar
from hazbot_gym.core.kinematics import Chassis, Pose, Twist, arc_step, body_velocity, wheel_speeds
from hazbot_gym.core.noise import WHEELS, uniform4
from hazbot_gym.core.pid import (
    PLANTS,
    PidGains,
    Plant,
    filtered_derivative,
    lagged_input,
    motor_gain,
    motor_step,
    pid_law,
)
from hazbot_gym.core.state import LEFT, RIGHT, ROBOT, WHEEL, Floats, Record, Records, records
from hazbot_gym.core.tracking import TrackingGains, pose_error, tracking_law
from hazbot_gym.errors import InvalidInput

if TYPE_CHECKING:
    from hazbot_gym.config import Drive

_EACH, _EACH_WHEEL = ("f8", (LANES,)), ("f8", (2, LANES))
DRIVE_LANES = np.dtype(
    [
        *((name, *_EACH) for name in ("command", "v_ref", "s", "x", "y", "theta", "v", "omega")),
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
)  # fields of ROBOT and WHEEL, each as an array over lanes, and what a step works with

FUZZY_PID, PID, IDEAL = 0, 1, 2
WHEEL_LOOPS = ("fuzzy_pid", "pid", "ideal")
LOST_M = 1.0  # along-track error with which nobody arrives: the wheel loop has diverged


class DriveParameters(NamedTuple):
    """The ``drive`` section of the config as numbers; ``as_record`` makes it ready for kernels."""

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


def drive_parameters(drive: Drive, physics_s: float) -> DriveParameters:
    """Return the parameters of the kernels for a config and a physics step [s]."""
    return DriveParameters(
        dt_s=physics_s,
        nominal_speed_mps=drive.nominal_speed_mps,
        acceleration_mps2=drive.acceleration_mps2,
        deceleration_mps2=drive.deceleration_mps2,
        wheel_loop=WHEEL_LOOPS.index(drive.wheel_loop),
        wheel_noise_radps=drive.wheel_noise_radps,
        heading_noise_rad=drive.heading_noise_rad,
        chassis=drive.chassis,
        tracking=drive.tracking,
        plant=PLANTS[drive.plant] if isinstance(drive.plant, str) else drive.plant,
        pid=drive.pid,
        fuzzy=drive.fuzzy,
    )


# --- one physics step ----------------------------------------------------------------------------


@scalar
def slew(speed_mps: float, command_mps: float, p: DriveParameters) -> float:
    """Return the reference speed one physics step later, on its way to the command [m/s]."""
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
def values_of(p: Record) -> DriveParameters:
    """Return the parameters as values: what a loop reads from memory might change under it."""
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
    )  # fmt: skip


@scalar
def load_lane(
    lanes: Record, i: int, robot: Record, wheels: Records, key: np.uint64, step: int
) -> None:
    """Take a robot and its wheels into lane i.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        i: Which lane.
        robot: Record of type ``ROBOT``.
        wheels: (2,) records of type ``WHEEL``.
        key: Key of the scenario's noise.
        step: Physics steps since the start of the episode.
    """
    lanes.key[i], lanes.step[i] = key, step
    lanes.command[i], lanes.v_ref[i], lanes.s[i] = robot.command, robot.v_ref, robot.s
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
def store_lane(lanes: Record, i: int, robot: Record, wheels: Records) -> None:
    """Write lane i back to its robot and wheels, which have made at least one step in it."""
    robot.v_ref, robot.s = lanes.v_ref[i], lanes.s[i]
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
def aim_lane(lanes: Record, i: int, path: Records, reach_m: float) -> None:
    """Note along which line lane i's reference point runs, if it stays on one for a while.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        i: Which lane.
        path: (M,) records of type ``PATH_PIECE``.
        reach_m: How far the reference point may come before the lane is aimed again [m].
    """
    piece = path[piece_at(path, lanes.s[i])]
    is_last = piece.s + piece.length >= path_length(path)
    is_within = is_last or lanes.s[i] + reach_m < piece.s + piece.length
    lanes.is_straight[i] = abs(piece.curvature) < STRAIGHT_PER_M and is_within
    lanes.x_0[i], lanes.y_0[i], lanes.s_0[i] = piece.x, piece.y, piece.s
    lanes.cos[i], lanes.sin[i] = piece.cos, piece.sin
    lanes.theta_r[i], lanes.curvature[i] = piece.heading, 0.0


@scalar
def follow_lane(lanes: Record, i: int, path: Records) -> None:
    """Put lane i's reference point onto its path where that is not a line."""
    if not lanes.is_straight[i]:
        lanes.x_r[i], lanes.y_r[i], lanes.theta_r[i], lanes.curvature[i] = path_pose(
            path, lanes.s[i]
        )


@scalar
def follow_lines(lanes: Record) -> None:
    """Put the reference points of all lanes onto their lines; ``follow_lane`` has the exceptions.

    On a line ``path_pose`` is just this.
    """
    for i in range(LANES):
        along = lanes.s[i] - lanes.s_0[i]
        lanes.x_r[i] = lanes.x_0[i] + along * lanes.cos[i]
        lanes.y_r[i] = lanes.y_0[i] + along * lanes.sin[i]


@scalar
def _disturb(lanes: Record, p: DriveParameters) -> None:
    """Draw the measurement noise of a step."""
    for i in range(LANES):
        right, left, heading = measurement_noise(p, lanes.key[i], lanes.step[i])
        lanes.noise[RIGHT, i], lanes.noise[LEFT, i], lanes.heading_noise[i] = right, left, heading
        lanes.step[i] += 1


@scalar
def _steer(lanes: Record, p: DriveParameters) -> None:
    """Let the reference points gain speed, and ask the wheels for speeds that follow them."""
    for i in range(LANES):
        v_ref = slew(lanes.v_ref[i], lanes.command[i], p)
        measured = Pose(lanes.x[i], lanes.y[i], lanes.theta[i] + lanes.heading_noise[i])
        error = pose_error(measured, Pose(lanes.x_r[i], lanes.y_r[i], lanes.theta_r[i]))
        velocity = tracking_law(error, Twist(v_ref, v_ref * lanes.curvature[i]), p.tracking)
        w1, w2 = wheel_speeds(velocity, p.chassis)
        lanes.v_ref[i], lanes.wanted[RIGHT, i], lanes.wanted[LEFT, i] = v_ref, w1, w2


@scalar
def _measure(lanes: Record, w: int, p: DriveParameters) -> None:
    """Take the control errors of the wheels on one side."""
    for i in range(LANES):
        error = lanes.wanted[w, i] - (lanes.speed[w, i] + lanes.noise[w, i])
        lanes.derivative[w, i] = filtered_derivative(
            lanes.derivative[w, i], error, lanes.error[w, i], p.dt_s, p.plant.Tf
        )
        lanes.error[w, i] = error
        lanes.integral[w, i] += error * p.dt_s


@scalar
def _turn(lanes: Record, w: int, p: DriveParameters) -> None:
    """Drive the motors on one side."""
    gain = motor_gain(p.plant, w == RIGHT)
    for i in range(LANES):
        gains = PidGains(lanes.kp[w, i], lanes.ki[w, i], lanes.kd[w, i])
        u = pid_law(lanes.error[w, i], lanes.integral[w, i], lanes.derivative[w, i], gains)
        drive = lagged_input(lanes.drive[w, i], u, p.plant, p.dt_s)
        lanes.speed[w, i] = motor_step(lanes.speed[w, i], drive, gain, p.plant.T1, p.dt_s)
        lanes.drive[w, i] = drive


@scalar
def _roll(lanes: Record, p: DriveParameters) -> None:
    """Move the robots as their wheels turn, and the reference points along the path."""
    for i in range(LANES):
        actual = body_velocity(lanes.speed[RIGHT, i], lanes.speed[LEFT, i], p.chassis)
        pose = arc_step(Pose(lanes.x[i], lanes.y[i], lanes.theta[i]), actual, p.dt_s)
        lanes.v[i], lanes.omega[i] = actual.v, actual.omega
        lanes.x[i], lanes.y[i], lanes.theta[i] = pose.x, pose.y, pose.theta
        lanes.s[i] += lanes.v_ref[i] * p.dt_s


@routine
def drive_step(lanes: Record, p: DriveParameters, gain_table: Floats) -> None:
    """Advance all lanes by one physics step towards their commands; reference poses are set.

    The loops over lanes are written so that they compile to vector instructions, four lanes at a
    time: no calls, no branches that differ between lanes, values instead of records for parameters.

    Args:
        lanes: Record of type ``DRIVE_LANES``.
        p: From ``values_of``.
        gain_table: From ``core.fuzzy_pid.gain_table``.
    """
    if p.wheel_noise_radps > 0.0 or p.heading_noise_rad > 0.0:
        _disturb(lanes, p)
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
def update_pose_error(robot: Record, path: Records) -> None:
    """Write the true pose error (eq 10) of the robot into its record."""
    x_r, y_r, theta_r, _ = path_pose(path, robot.s)
    error = pose_error(Pose(robot.x, robot.y, robot.theta), Pose(x_r, y_r, theta_r))
    robot.x_e, robot.y_e, robot.theta_e = error.x, error.y, error.theta


# --- entry points --------------------------------------------------------------------------------


@kernel
def drive(
    robots: Records,
    wheels: Records,
    path: Records,
    command_mps: float,
    parameters: Records,
    gain_table: Floats,
    key: np.uint64,
    first_step: int,
    substeps: int,
    lanes: Records,
) -> None:
    """Drive one robot for some physics steps at a commanded speed.

    Args:
        robots: (1,) record of type ``ROBOT``, changed in place like the wheels.
        wheels: (2,) records of type ``WHEEL``.
        path: (M,) records of type ``PATH_PIECE``.
        command_mps: Speed that the policy asks for [m/s].
        parameters: (1,) record of ``DriveParameters``.
        gain_table: From ``core.fuzzy_pid.gain_table``.
        key: Key of the scenario's noise.
        first_step: Physics steps since the start of the episode.
        substeps: How many physics steps to drive.
        lanes: (1,) record of type ``DRIVE_LANES`` to work in.
    """
    robots[0].command = command_mps
    p = values_of(parameters[0])
    load_lane(lanes[0], 0, robots[0], wheels, np.uint64(key), first_step)
    for _ in range(substeps):
        aim_lane(lanes[0], 0, path, p.nominal_speed_mps * p.dt_s)
        follow_lines(lanes[0])
        follow_lane(lanes[0], 0, path)
        drive_step(lanes[0], p, gain_table)
    store_lane(lanes[0], 0, robots[0], wheels)
    update_pose_error(robots[0], path)


@routine
def place_robot(
    robot: Record,
    wheels: Records,
    path: Records,
    speed_mps: float,
    p: DriveParameters,
    gain_table: Floats,
) -> None:
    """Place the robot at the start of its path, at rest or already rolling on it at a speed [m/s].

    A rolling robot's wheel loops are settled: their integrals hold just the input it takes.
    """
    robot.x, robot.y, robot.theta, curvature = path_pose(path, 0.0)
    robot.v, robot.omega = speed_mps, speed_mps * curvature
    robot.command, robot.v_ref, robot.s = speed_mps, speed_mps, 0.0
    robot.x_e, robot.y_e, robot.theta_e = 0.0, 0.0, 0.0
    speeds = wheel_speeds(Twist(robot.v, robot.omega), p.chassis)
    ki = loop_gains(0.0, 0.0, p, gain_table).ki
    for i in (RIGHT, LEFT):
        wheel = wheels[i]
        wheel.speed = speeds[i]
        wheel.drive = speeds[i] / motor_gain(p.plant, i == RIGHT)
        wheel.integral = wheel.drive / ki if ki > 0.0 else 0.0
        wheel.error = np.nan  # there is no sample yet
        wheel.derivative = 0.0


@kernel
def start_drive(
    robots: Records,
    wheels: Records,
    path: Records,
    speed_mps: float,
    parameters: Records,
    gain_table: Floats,
) -> None:
    """Start a drive; ``place_robot`` for arrays of one record."""
    place_robot(robots[0], wheels, path, speed_mps, parameters[0], gain_table)


@kernel
def _steps_to_end(
    robots: Records,
    wheels: Records,
    path: Records,
    goal_m: float,
    parameters: Records,
    gain_table: Floats,
    horizon: int,
    lanes: Records,
) -> int:
    robot, p = robots[0], values_of(parameters[0])
    robot.command = p.nominal_speed_mps
    load_lane(lanes[0], 0, robot, wheels, np.uint64(0), 0)
    for step in range(1, horizon + 1):
        aim_lane(lanes[0], 0, path, p.nominal_speed_mps * p.dt_s)
        follow_lines(lanes[0])
        follow_lane(lanes[0], 0, path)
        drive_step(lanes[0], p, gain_table)
        store_lane(lanes[0], 0, robot, wheels)
        update_pose_error(robot, path)
        if robot.s + robot.x_e >= goal_m:
            return step if abs(robot.x_e) < LOST_M else -1
    return -1


def free_time_s(
    path: Records,
    parameters: Records,
    gain_table: Floats,
    start_speed_mps: float = 0.0,
    arrival_tolerance_m: float = 0.0,
) -> float:
    """Return how long the robot takes along a path at full speed, alone and without noise [s].

    It has arrived when ``s + x_e``, its own place on the path, is within the tolerance of the end.

    Raises:
        InvalidInput: the drive does not reach the end in ten times the time at nominal speed.
    """
    robots, wheels = records(ROBOT, 1), records(WHEEL, 2)
    quiet = parameters.copy()
    quiet["wheel_noise_radps"] = quiet["heading_noise_rad"] = 0.0
    robot, wheel, p = (x.view(np.recarray) for x in (robots, wheels, quiet))
    place_robot(robot[0], wheel, path.view(np.recarray), start_speed_mps, p[0], gain_table)
    dt_s, nominal_mps = float(quiet["dt_s"][0]), float(quiet["nominal_speed_mps"][0])
    length_m = path_length(path.view(np.recarray))
    horizon = int((10.0 * length_m / nominal_mps + 10.0) / dt_s)
    goal_m = length_m - arrival_tolerance_m
    lanes = records(DRIVE_LANES, 1)
    steps = _steps_to_end(robots, wheels, path, goal_m, quiet, gain_table, horizon, lanes)
    if steps < 0:
        raise InvalidInput(
            f"drive: does not reach the end of a path of {length_m:.2f} m in "
            f"{horizon * dt_s:.0f} s; "
            "allowed are a plant, gains and limits with which it does"
        )
    return steps * dt_s
