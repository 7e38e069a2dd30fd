"""Circle tracking (paper section 5.2, Table 3, Figures 17, 18, 20): one lap and its figures.

The robot stands at the start of the circle while its reference sets off at full speed (scenario
``circle``). The position error is hypot(x_e, y_e), the angle error |theta_e|; an error has
converged when it is below 0.001 m or rad for good, the third decimal that the paper resolves (A12,
docs/paper.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Drive, make_config
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.geometry import circle_path, path_length, path_pose
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.kinematics import Pose
from hazbot_gym.core.state import LEFT, RIGHT, ROBOT, WHEEL, Floats, Records, as_record, records
from hazbot_gym.paper.numbers import reported
from hazbot_gym.sim.drive import drive_parameters, place_kernel, update_pose_error
from hazbot_gym.sim.lanes import DRIVE_LANES, drive_alone, drive_values, load_lane, store_lane
from hazbot_gym.task.place_data import build_place
from hazbot_gym.task.places import CIRCLE_RADIUS_M, circle

START = Pose(*path_pose(build_place(circle()).path.view(np.recarray), 0.0)[:3])
BAND = 0.001  # of a converged error [m, rad]
PHYSICS_S = 0.01  # the paper's sampling interval
NOISE = {  # of Table 2, the drive's default
    name: Drive.model_fields[name].default for name in ("wheel_noise_radps", "heading_noise_rad")
}
COLUMNS = ("s", "x", "y", "x_e", "y_e", "theta_e")


class Load(NamedTuple):
    """A load step on both motors, given by its steady-state slowdown."""

    from_s: float
    drop_radps: float  # of a wheel without control


NO_LOAD = Load(0.0, 0.0)


class Lap(NamedTuple):
    """A lap, sampled after every physics step; all arrays (T,)."""

    time_s: Floats
    x_r: Floats  # reference point [m]
    y_r: Floats
    x: Floats
    y: Floats
    position_m: Floats  # position error
    angle_rad: Floats  # angle error


class Figures(NamedTuple):
    """The four numbers that the paper reports of a controller."""

    position_max_m: float
    angle_max_rad: float
    position_converged_s: float
    angle_converged_s: float


FIGURE_NAMES = (  # of ``Figures``, as heads of tables
    "largest position error [m]",
    "largest angle error [rad]",
    "position converged [s]",
    "angle converged [s]",
)


def paper_drive(**changes: object) -> Drive:
    """Return the drive of the scenario ``circle`` with some values changed."""
    return make_config(scenario="circle", drive=changes).drive


def reported_figures(controller: str) -> Figures:
    """Return the four numbers that the paper reports of ``"fuzzy-PID"`` or ``"PID"``."""
    numbers, short = reported().numbers, {"fuzzy-PID": "fuzzy", "PID": "pid"}[controller]
    return Figures(*(numbers[f"circle_{short}_{field}"].paper for field in Figures._fields))


@lean_kernel
def _drive_lap(
    robots: Records, wheels: Records, path: Records, command_mps: float, parameters: Records,
    table: Floats, key: np.uint64, load: Load, lanes: Records, out: Floats,
) -> None:  # fmt: skip
    """Write ``COLUMNS`` after every step: (T, 6)."""
    robot, p = robots[0], drive_values(parameters[0])
    robot.obeyed = command_mps
    load_lane(lanes[0], 0, robot, wheels, np.uint64(key), 0)
    for k in range(out.shape[0]):
        drive_alone(lanes[0], 0, path, p, table)
        if load.drop_radps != 0.0 and k * p.dt_s >= load.from_s:
            for w in (RIGHT, LEFT):
                lanes[0].speed[w, 0] -= load.drop_radps * p.dt_s / p.plant.T1
        store_lane(lanes[0], 0, robot, wheels)
        update_pose_error(robot, path)
        out[k, 0], out[k, 1], out[k, 2] = robot.s, robot.x, robot.y
        out[k, 3], out[k, 4], out[k, 5] = robot.x_e, robot.y_e, robot.theta_e


def drive_lap(
    drive: Drive,
    *,
    radius_m: float = CIRCLE_RADIUS_M,
    physics_s: float = PHYSICS_S,
    load: Load = NO_LOAD,
    key: int = 0,
) -> Lap:
    """Drive one lap at nominal speed from rest.

    Args:
        drive: The drive; ``paper_drive()`` is the paper's.
        radius_m: Of the circle.
        physics_s: Sampling interval.
        load: On the motors.
        key: Of the measurement noise, if the drive has any.
    """
    path = circle_path(*START, radius_m)
    parameters = as_record(drive_parameters(drive, physics_s))
    table = gain_table(drive.tables)
    robots, wheels = records(ROBOT, 1), records(WHEEL, 2)
    place_kernel(robots, wheels, path, 0.0, parameters, table)
    lap_s = path_length(path.view(np.recarray)) / drive.nominal_speed_mps
    out = np.empty((int(lap_s / physics_s), len(COLUMNS)))
    _drive_lap(
        robots, wheels, path, drive.nominal_speed_mps, parameters, table, np.uint64(key), load,
        records(DRIVE_LANES, 1), out,
    )  # fmt: skip
    s, x, y, x_e, y_e, theta_e = out.T
    return Lap(
        time_s=physics_s * np.arange(1, len(out) + 1, dtype=np.float64),
        x_r=radius_m * np.sin(s / radius_m),
        y_r=radius_m * (1.0 - np.cos(s / radius_m)),
        x=x,
        y=y,
        position_m=np.hypot(x_e, y_e),
        angle_rad=np.abs(theta_e),
    )


def converged_s(time_s: Floats, error: Floats, band: float = BAND) -> float:
    """Return the time after which an error stays below a band; the end of the lap if never."""
    above = np.flatnonzero(~(error < band))  # a NaN has not converged
    return float(time_s[above[-1]]) if len(above) else 0.0


def figures(lap: Lap, band: float = BAND) -> Figures:
    """Return the four numbers of a lap; a lap that diverged has infinite errors."""
    return Figures(
        _largest(lap.position_m),
        _largest(lap.angle_rad),
        converged_s(lap.time_s, lap.position_m, band),
        converged_s(lap.time_s, lap.angle_rad, band),
    )


def _largest(error: Floats) -> float:
    return float(error.max()) if np.isfinite(error).all() else np.inf


class Point(NamedTuple):
    """A row of Table 3."""

    xr: float  # target [m]
    yr: float
    x: float  # robot [m]
    y: float
    position: float  # error [m]
    angle: float  # error [rad]


# As printed, errors included.
TABLE_3 = (
    Point(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    Point(3.431, 3.438, 3.434, 3.451, 0.014, 0.007),
    Point(0.004, 6.862, 0.004, 6.861, 0.001, 0.0),
    Point(-3.431, 3.427, -3.431, -3.427, 0.0, 0.0),
    Point(0.002, 0.0, -0.002, 0.0, 0.0, 0.0),
)


def critical_points(lap: Lap) -> list[Point]:
    """Return our Table 3: the robot's position when the target is nearest to each printed target.

    The first row is the start, before any step; every other one is searched within an eighth of a
    lap around its quarter, since the last target equals the first.
    """
    found = [Point(START.x, START.y, START.x, START.y, 0.0, 0.0)]
    steps = len(lap.time_s)
    for quarter, printed in enumerate(TABLE_3[1:], start=1):
        first, last = ((2 * quarter + side) * steps // 8 for side in (-1, 1))
        window = slice(first, min(last, steps))
        away = np.hypot(lap.x_r[window] - printed.xr, lap.y_r[window] - printed.yr)
        k = first + int(np.argmin(away))
        row = (lap.x_r, lap.y_r, lap.x, lap.y, lap.position_m, lap.angle_rad)  # of ``Point``
        found.append(Point._make(float(column[k]) for column in row))
    return found


def printed_errors() -> list[float]:
    """Return the position errors that follow from the coordinates printed in Table 3 [m]."""
    return [float(np.hypot(row.x - row.xr, row.y - row.yr)) for row in TABLE_3]
