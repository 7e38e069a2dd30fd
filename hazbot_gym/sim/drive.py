"""The execution layer: from a commanded speed to the robot's motion along its path.

Once every physics step: slew limit -> reference point on the path -> tracking law (12c) -> wheel
speeds (13) -> wheel loops (14, 15) on mismatched motors -> pose (1-3). The order of the steps is
that of SPEC section 5, whose figures it reproduces. Left out: slip, steering by the policy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hazbot_gym.core.fuzzy_pid import FuzzyPid, fuzzy_pid_gains
from hazbot_gym.core.geometry import clip, path_length, path_pose
from hazbot_gym.core.jit import kernel, scalar
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
    if p.wheel_noise_radps == 0.0 and p.heading_noise_rad == 0.0:
        return 0.0, 0.0, 0.0
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
def wheel_substep(
    wheel: Record, command: float, noise: float, gain: float, p: DriveParameters, table: Floats
) -> None:
    """Advance one wheel by a physics step: control error, gains, motor input, motor.

    Args:
        wheel: Record of type ``WHEEL``, changed in place.
        command: Wheel speed that the tracking law asks for [rad/s].
        noise: Error of the measured wheel speed [rad/s].
        gain: K_i of this wheel's motor.
        p: Parameters of the drive.
        table: Gain table of the fuzzy-PID.
    """
    if p.wheel_loop == IDEAL:
        wheel.speed = command
        return
    error = command - (wheel.speed + noise)
    wheel.derivative = filtered_derivative(wheel.derivative, error, wheel.error, p.dt_s, p.plant.Tf)
    wheel.error = error
    wheel.integral += error * p.dt_s
    gains = loop_gains(error, wheel.derivative, p, table)
    u = pid_law(error, wheel.integral, wheel.derivative, gains)
    wheel.drive = lagged_input(wheel.drive, u, p.plant, p.dt_s)
    wheel.speed = motor_step(wheel.speed, wheel.drive, gain, p.plant.T1, p.dt_s)


@scalar
def drive_substep(
    robot: Record,
    wheels: Records,
    path: Records,
    p: DriveParameters,
    gain_table: Floats,
    key: np.uint64,
    step: int,
) -> None:
    """Advance robot and wheels by one physics step towards ``robot.command``, in place.

    The pose error in the record is left as it was: call ``update_pose_error`` where it is read.

    Args:
        robot: Record of type ``ROBOT``.
        wheels: (2,) records of type ``WHEEL``.
        path: (M,) records of type ``PATH_PIECE``.
        p: Parameters of the drive.
        gain_table: From ``core.fuzzy_pid.gain_table``.
        key: Key of the scenario's noise.
        step: Physics steps since the start of the episode.
    """
    robot.v_ref = slew(robot.v_ref, robot.command, p)
    noise_right, noise_left, noise_heading = measurement_noise(p, key, step)
    x_r, y_r, theta_r, curvature = path_pose(path, robot.s)
    measured = Pose(robot.x, robot.y, robot.theta + noise_heading)
    error = pose_error(measured, Pose(x_r, y_r, theta_r))
    velocity = tracking_law(error, Twist(robot.v_ref, robot.v_ref * curvature), p.tracking)
    w1, w2 = wheel_speeds(velocity, p.chassis)
    wheel_substep(wheels[RIGHT], w1, noise_right, motor_gain(p.plant, True), p, gain_table)
    wheel_substep(wheels[LEFT], w2, noise_left, motor_gain(p.plant, False), p, gain_table)
    actual = body_velocity(wheels[RIGHT].speed, wheels[LEFT].speed, p.chassis)
    pose = arc_step(Pose(robot.x, robot.y, robot.theta), actual, p.dt_s)
    robot.v, robot.omega = actual.v, actual.omega
    robot.x, robot.y, robot.theta = pose.x, pose.y, pose.theta
    robot.s += robot.v_ref * p.dt_s


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
) -> None:
    """Drive for some physics steps at a commanded speed; see ``drive_substep`` for the arguments.

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
    """
    robots[0].command = command_mps
    for step in range(first_step, first_step + substeps):
        drive_substep(robots[0], wheels, path, parameters[0], gain_table, np.uint64(key), step)
    update_pose_error(robots[0], path)


@scalar
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
) -> int:
    robot, p = robots[0], parameters[0]
    robot.command = p.nominal_speed_mps
    for step in range(1, horizon + 1):
        drive_substep(robot, wheels, path, p, gain_table, np.uint64(0), step)
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
    start_drive(robots, wheels, path, start_speed_mps, quiet, gain_table)
    dt_s, nominal_mps = float(quiet["dt_s"][0]), float(quiet["nominal_speed_mps"][0])
    length_m = path_length(path.view(np.recarray))
    horizon = int((10.0 * length_m / nominal_mps + 10.0) / dt_s)
    goal_m = length_m - arrival_tolerance_m
    steps = _steps_to_end(robots, wheels, path, goal_m, quiet, gain_table, horizon)
    if steps < 0:
        raise InvalidInput(
            f"drive: does not reach the end of a path of {length_m:.2f} m in "
            f"{horizon * dt_s:.0f} s; "
            "allowed are a plant, gains and limits with which it does"
        )
    return steps * dt_s
