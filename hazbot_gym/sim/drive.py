"""Drive: from a commanded speed to the robot's motion along its path.

Once every physics step: slew limit -> reference point on the path -> tracking law (12c) -> wheel
speeds (13) -> wheel loops (14, 15) on mismatched motors -> pose (1-3). This order of the steps
reproduces the figures of the paper's circle (docs/paper.md). Not modeled: wheel slip, and steering
by the policy.

The physics step is in ``lanes.py``, vectorized over robots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.geometry import path_length, path_pose
from hazbot_gym.core.jit import lean_kernel, routine, scalar
from hazbot_gym.core.kinematics import Pose, Twist, wheel_speeds
from hazbot_gym.core.pid import PLANTS, motor_gain
from hazbot_gym.core.state import LEFT, RIGHT, ROBOT, WHEEL, Floats, Records, RobotRecord, records
from hazbot_gym.core.tracking import pose_error
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.lanes import (
    DRIVE_LANES,
    DriveParameters,
    drive_alone,
    drive_values,
    load_lane,
    loop_gains,
    store_lane,
)

if TYPE_CHECKING:
    from hazbot_gym.config import Drive

WHEEL_LOOPS = ("fuzzy_pid", "pid", "ideal")
MOST_STEPS_ALONE = 20_000_000  # limit of computing time [s], ample for a path of kilometers
LOST_M = 1.0  # along-track error of a diverged wheel loop


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
        line=drive.line_sensor,
    )


@scalar
def command_robot(
    robot: RobotRecord, command_mps: float, stops: bool, pending: Floats, step: int
) -> None:
    """Queue a command, and apply the command of ``latency`` decisions ago.

    A reflex stop applies immediately.

    Args:
        robot: The robot's record.
        command_mps: Command of the policy [m/s].
        stops: Whether the robot stops by reflex instead.
        pending: (latency + 1,) ring buffer of pending commands [m/s].
        step: Number of the decision since the reset.
    """
    robot.command = 0.0 if stops else command_mps
    room = pending.shape[0]
    pending[step % room] = robot.command
    robot.obeyed = 0.0 if stops else pending[(step + 1) % room]


@scalar
def update_pose_error(robot: RobotRecord, path: Records) -> None:
    """Write the true pose error (eq 10) of the robot into its record."""
    x_r, y_r, theta_r, _ = path_pose(path, robot.s)
    error = pose_error(Pose(robot.x, robot.y, robot.theta), Pose(x_r, y_r, theta_r))
    robot.x_e, robot.y_e, robot.theta_e = error.x, error.y, error.theta


# --- entry points --------------------------------------------------------------------------------


@lean_kernel
def command_kernel(
    robots: Records, command_mps: float, stops: bool, pending: Floats, step: int
) -> None:
    """Entry point from Python: ``command_robot`` for an array of one record."""
    command_robot(robots[0], command_mps, stops, pending, step)


@lean_kernel
def drive(
    robots: Records,
    wheels: Records,
    path: Records,
    parameters: Records,
    gain_table: Floats,
    key: np.uint64,
    first_step: int,
    substeps: int,
    lanes: Records,
) -> None:
    """Drive one robot for some physics steps at its effective command.

    Args:
        robots: (1,) record of type ``ROBOT``, changed in place like the wheels.
        wheels: (2,) records of type ``WHEEL``.
        path: (M,) records of type ``PATH_PIECE``.
        parameters: (1,) record of ``DriveParameters``.
        gain_table: From ``core.fuzzy_pid.gain_table``.
        key: Key of the scenario's noise.
        first_step: Physics steps since the start of the episode.
        substeps: Number of physics steps.
        lanes: (1,) record of type ``DRIVE_LANES``, scratch.
    """
    p = drive_values(parameters[0])
    load_lane(lanes[0], 0, robots[0], wheels, np.uint64(key), first_step)
    for _ in range(substeps):
        drive_alone(lanes[0], 0, path, p, gain_table)
    store_lane(lanes[0], 0, robots[0], wheels)
    update_pose_error(robots[0], path)


@routine
def place_robot(
    robot: RobotRecord,
    wheels: Records,
    path: Records,
    speed_mps: float,
    p: DriveParameters,
    gain_table: Floats,
) -> None:
    """Place the robot at the start of its path, at an initial speed [m/s].

    The wheel loops start in steady state: their integral terms hold the required input.
    """
    robot.x, robot.y, robot.theta, curvature = path_pose(path, 0.0)
    robot.v, robot.omega = speed_mps, speed_mps * curvature
    robot.command, robot.obeyed, robot.v_ref, robot.s = speed_mps, speed_mps, speed_mps, 0.0
    robot.x_e, robot.y_e, robot.theta_e, robot.y_seen = 0.0, 0.0, 0.0, 0.0
    speeds = wheel_speeds(Twist(robot.v, robot.omega), p.chassis)
    ki = loop_gains(0.0, 0.0, p, gain_table).ki
    for i in (RIGHT, LEFT):
        wheel = wheels[i]
        wheel.speed = speeds[i]
        wheel.drive = speeds[i] / motor_gain(p.plant, i == RIGHT)
        wheel.integral = wheel.drive / ki if ki > 0.0 else 0.0
        wheel.error = np.nan  # no sample yet
        wheel.derivative = 0.0


@lean_kernel
def place_kernel(
    robots: Records,
    wheels: Records,
    path: Records,
    speed_mps: float,
    parameters: Records,
    gain_table: Floats,
) -> None:
    """Entry point from Python: ``place_robot`` for arrays of one record."""
    place_robot(robots[0], wheels, path, speed_mps, parameters[0], gain_table)


@lean_kernel
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
    robot, p = robots[0], drive_values(parameters[0])
    robot.obeyed = p.nominal_speed_mps
    load_lane(lanes[0], 0, robot, wheels, np.uint64(0), 0)
    for step in range(1, horizon + 1):
        drive_alone(lanes[0], 0, path, p, gain_table)
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
    """Return the travel time of a path at full speed, without people and noise [s].

    The robot has arrived once ``s + x_e``, its actual place on the path, is within tolerance of the
    end.

    Raises:
        InvalidInput: the drive does not reach the end within ten times the time at nominal speed,
            or that time exceeds every horizon.
    """
    robots, wheels = records(ROBOT, 1), records(WHEEL, 2)
    quiet = parameters.copy()
    quiet["wheel_noise_radps"] = quiet["heading_noise_rad"] = 0.0
    robot, wheel, p = (x.view(np.recarray) for x in (robots, wheels, quiet))
    place_robot(robot[0], wheel, path.view(np.recarray), start_speed_mps, p[0], gain_table)
    dt_s, nominal_mps = float(quiet["dt_s"][0]), float(quiet["nominal_speed_mps"][0])
    length_m = path_length(path.view(np.recarray))
    horizon = int((10.0 * length_m / nominal_mps + 10.0) / dt_s)
    if horizon > MOST_STEPS_ALONE:
        raise InvalidInput(
            f"drive: a path of {length_m:.2f} m takes {length_m / nominal_mps:.4g} s at "
            f"nominal_speed_mps = {nominal_mps:g}; allowed are at most "
            f"{(MOST_STEPS_ALONE * dt_s - 10.0) / 10.0:.4g} s in physics steps of {dt_s:g} s"
        )
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
