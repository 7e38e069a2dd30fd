from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from hazbot_gym.config import Drive
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.geometry import circle_path, path_length, straight_path
from hazbot_gym.core.line_sensor import LineSensor
from hazbot_gym.core.pid import PLANTS
from hazbot_gym.core.state import LEFT, RIGHT, ROBOT, WHEEL, Floats, Records, as_record, records
from hazbot_gym.sim.drive import (
    command_robot,
    drive,
    drive_parameters,
    free_time_s,
    place_kernel,
    update_pose_error,
)
from hazbot_gym.sim.lanes import (
    DRIVE_LANES,
    DriveParameters,
    drive_alone,
    drive_values,
    load_lane,
    measurement_noise,
    store_lane,
)
from tests.refusals import refused

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "tracking_circle.json").read_text(encoding="utf-8")
)
DT_S = 0.01
TABLES = {name: gain_table(name) for name in ("textbook", "symmetric")}
AT_ONCE = {"acceleration_mps2": 1e9, "deceleration_mps2": 1e9}
QUIET = {"wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}
CIRCLE = circle_path(0.0, 0.0, 0.0, REFERENCE["radius_m"])
STRAIGHT = straight_path(np.array([[0.0, 0.0], [6.0, 0.0]]))
CORNER = straight_path(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]))


class Rig(NamedTuple):
    """A robot on a path with all that the kernels ask for."""

    robots: Records
    wheels: Records
    path: Records
    parameters: Records
    table: Floats

    def drive(self, command_mps: float, step: int = 0, substeps: int = 1, key: int = 7) -> Records:
        """Drive on and return the robot's record."""
        self.robots["command"] = self.robots["obeyed"] = command_mps
        drive(
            self.robots, self.wheels, self.path, self.parameters,
            self.table, np.uint64(key), step, substeps, records(DRIVE_LANES, 1),
        )  # fmt: skip
        return self.robots[0]


def make_rig(path: Records, start_mps: float = 0.0, **options: Any) -> Rig:
    settings = Drive(**{**QUIET, **options})
    parameters = as_record(drive_parameters(settings, DT_S))
    rig = Rig(records(ROBOT, 1), records(WHEEL, 2), path, parameters, TABLES[settings.tables])
    place_kernel(rig.robots, rig.wheels, path, start_mps, parameters, rig.table)
    return rig


def test_ideal_wheels_stay_on_the_circle() -> None:
    rig = make_rig(CIRCLE, wheel_loop="ideal", **AT_ONCE)
    robot = rig.drive(0.5, substeps=2000)

    assert robot["s"] == pytest.approx(10.0)
    assert math.hypot(robot["x_e"], robot["y_e"]) < 1e-9
    assert robot["omega"] == pytest.approx(0.5 / REFERENCE["radius_m"])


@pytest.mark.parametrize("wheel_loop", ["fuzzy_pid", "pid", "ideal"])
def test_robot_turns_a_corner_and_stays_near_its_path(wheel_loop: str) -> None:
    rig = make_rig(CORNER, wheel_loop=wheel_loop)
    worst = max(abs(float(rig.drive(0.5, step=10 * k, substeps=10)["y_e"])) for k in range(140))

    assert worst < 0.1
    assert rig.robots[0]["theta"] == pytest.approx(math.pi / 2, abs=0.05)


def test_reference_accelerates_and_brakes_within_the_slew_limits() -> None:
    rig = make_rig(STRAIGHT)

    assert rig.drive(0.5, substeps=50)["v_ref"] == pytest.approx(0.25)
    assert rig.drive(0.5, substeps=100)["v_ref"] == 0.5
    assert rig.drive(0.1, substeps=10)["v_ref"] == pytest.approx(0.4)
    assert rig.drive(0.1, substeps=100)["v_ref"] == pytest.approx(0.1)


def test_robot_that_is_told_to_stop_comes_to_rest() -> None:
    rig = make_rig(STRAIGHT, start_mps=0.5)
    robot = rig.drive(0.0, substeps=600)

    assert robot["s"] == pytest.approx(0.5**2 / 2.0, abs=0.01)
    assert abs(robot["v"]) < 0.005
    assert robot["command"] == 0.0


def test_robot_at_rest_without_a_command_does_not_move() -> None:
    rig = make_rig(CIRCLE)

    assert rig.drive(0.0, substeps=500)["x"] == 0.0
    assert rig.wheels["speed"].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("tables", ["textbook", "symmetric"])
@pytest.mark.parametrize("path", [STRAIGHT, CIRCLE])
@pytest.mark.parametrize("plant", ["A", "B"])
def test_rolling_start_is_a_steady_state(path: Records, plant: str, tables: str) -> None:
    rig = make_rig(path, start_mps=0.5, plant=plant, tables=tables)
    before = rig.wheels["speed"].copy()
    robot = rig.drive(0.5, substeps=1000)

    assert rig.wheels["speed"] == pytest.approx(before, abs=1e-9)
    assert math.hypot(robot["x_e"], robot["y_e"]) < 1e-9


def test_weaker_right_wheel_turns_a_starting_robot_to_the_right() -> None:
    assert make_rig(STRAIGHT, plant="A").drive(0.5, substeps=50)["theta"] < 0.0
    assert make_rig(STRAIGHT, plant="A0").drive(0.5, substeps=50)["theta"] == 0.0


def test_ten_substeps_are_ten_calls() -> None:
    once, often = make_rig(CORNER, wheel_noise_radps=0.01), make_rig(CORNER, wheel_noise_radps=0.01)
    for k in range(20):
        once.drive(0.5, step=10 * k, substeps=10)
        for i in range(10):
            often.drive(0.5, step=10 * k + i)

    assert once.robots.tobytes() == often.robots.tobytes()
    assert once.wheels.tobytes() == often.wheels.tobytes()


@pytest.mark.parametrize("wheel_loop", ["fuzzy_pid", "pid", "ideal"])
def test_compiled_drive_is_that_of_plain_python(wheel_loop: str) -> None:
    noise = {"wheel_noise_radps": 0.01, "heading_noise_rad": 0.002}
    rig = make_rig(CORNER, wheel_loop=wheel_loop, plant="B", **noise)
    plain = make_rig(CORNER, wheel_loop=wheel_loop, plant="B", **noise)
    robot, parameters = (x.view(np.recarray)[0] for x in (plain.robots, plain.parameters))
    robot.command = robot.obeyed = 0.5
    path, wheels = CORNER.view(np.recarray), plain.wheels.view(np.recarray)
    lanes = records(DRIVE_LANES, 1).view(np.recarray)[0]
    load_lane(lanes, 3, robot, wheels, np.uint64(7), 0)
    for _ in range(100):
        drive_alone(lanes, 3, path, drive_values(parameters), plain.table)
    store_lane(lanes, 3, robot, wheels)
    update_pose_error(robot, path)
    rig.drive(0.5, substeps=100)

    for name in ROBOT.names or ():
        assert rig.robots[name] == pytest.approx(plain.robots[name], abs=1e-12)
    for name in WHEEL.names or ():
        assert rig.wheels[name] == pytest.approx(plain.wheels[name], abs=1e-10, nan_ok=True)


def test_same_key_is_the_same_drive_and_another_key_is_another() -> None:
    def end(key: int, half_width: float) -> float:
        noise = {"wheel_noise_radps": half_width, "heading_noise_rad": half_width / 5.0}
        return float(make_rig(STRAIGHT, **noise).drive(0.5, substeps=300, key=key)["y"])

    assert end(1, 0.01) == end(1, 0.01)
    assert end(1, 0.01) != end(2, 0.01)
    assert end(1, 0.0) == end(2, 0.0)


def test_measurement_noise_fills_its_half_widths() -> None:
    p = drive_parameters(Drive(wheel_noise_radps=0.01, heading_noise_rad=0.002), DT_S)
    draws = np.array([measurement_noise(p, np.uint64(3), step) for step in range(2000)])

    assert np.abs(draws).max(axis=0) == pytest.approx([0.01, 0.01, 0.002], rel=0.01)
    assert draws.mean(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=5e-4)
    assert abs(np.corrcoef(draws[:, RIGHT], draws[:, LEFT])[0, 1]) < 0.1


def test_noise_moves_the_robot_by_millimetres() -> None:
    noise = {"wheel_noise_radps": 0.01, "heading_noise_rad": 0.002}
    robot = make_rig(STRAIGHT, start_mps=0.5, **noise).drive(0.5, substeps=1000)

    assert 0.0 < math.hypot(robot["x_e"], robot["y_e"]) < 0.005


def test_free_time_of_ideal_wheels_is_the_time_of_the_slew_limit() -> None:
    rig = make_rig(STRAIGHT, wheel_loop="ideal")
    # 0.25 m while it accelerates for 1 s, the rest at 0.5 m/s, up to 0.1 m before the end of 6 m.
    expected = 1.0 + (6.0 - 0.1 - 0.25) / 0.5

    time_s = free_time_s(STRAIGHT, rig.parameters, rig.table, arrival_tolerance_m=0.1)

    assert time_s == pytest.approx(expected, abs=0.02)


def test_free_time_is_shorter_from_a_rolling_start_and_ignores_noise() -> None:
    rig = make_rig(CORNER, wheel_noise_radps=0.5)
    rolling = free_time_s(CORNER, rig.parameters, rig.table, start_speed_mps=0.5)

    assert rolling == pytest.approx(path_length(CORNER.view(np.recarray)) / 0.5, abs=0.1)
    assert rolling < free_time_s(CORNER, make_rig(CORNER).parameters, rig.table)


@pytest.mark.parametrize("change", [{"u_max": 1e-3}, {"Tf": 0.0}], ids=["too weak", "unstable"])
def test_drive_that_never_arrives_is_refused(change: dict[str, float]) -> None:
    rig = make_rig(STRAIGHT, plant=PLANTS["A"]._replace(**change))

    with refused("end of a path"):
        free_time_s(STRAIGHT, rig.parameters, rig.table)


def test_parameters_are_the_config_in_numbers() -> None:
    p = drive_parameters(Drive(plant="B", wheel_loop="pid", acceleration_mps2=0.3), DT_S)

    assert isinstance(p, DriveParameters)
    assert p.plant == PLANTS["B"]
    assert (p.wheel_loop, p.acceleration_mps2, p.dt_s) == (1, 0.3, DT_S)
    assert drive_parameters(Drive(plant=PLANTS["C"]), DT_S).plant == PLANTS["C"]


# --- latency and the line sensor -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("latency_steps", "expected"),
    [
        (0, [0.1, 0.5, 0.3, 0.0, 0.4]),
        (1, [0.2, 0.1, 0.5, 0.3, 0.0]),
        (3, [0.2, 0.2, 0.2, 0.1, 0.5]),  # what it started with, before there is a command
    ],
)
def test_drive_obeys_the_command_of_some_decisions_ago(
    latency_steps: int, expected: list[float]
) -> None:
    robot, pending = records(ROBOT, 1).view(np.recarray)[0], np.full(latency_steps + 1, 0.2)
    obeyed = []
    for k, command_mps in enumerate([0.1, 0.5, 0.3, 0.0, 0.4]):
        command_robot(robot, command_mps, False, pending, k)
        assert robot.command == command_mps
        obeyed.append(float(robot.obeyed))

    assert obeyed == expected


def test_a_stop_by_reflex_is_obeyed_at_once_and_noted_as_the_command() -> None:
    robot, pending = records(ROBOT, 1).view(np.recarray)[0], np.full(3, 0.5)
    command_robot(robot, 0.5, True, pending, 0)
    assert robot.command == robot.obeyed == 0.0
    for k, obeyed in ((1, 0.5), (2, 0.0)):  # later, what came before it and then itself
        command_robot(robot, 0.5, False, pending, k)
        assert robot.obeyed == obeyed


def lap(line_sensor: LineSensor) -> Floats:
    """Return the cross-track error of a lap at every step [m], the start from rest included."""
    rig = make_rig(CIRCLE, plant="B", line_sensor=line_sensor, **AT_ONCE)
    return np.array([rig.drive(0.5, step=k)["y_e"] for k in range(4311)])


def test_robot_with_eight_lamps_stays_within_half_a_pitch_of_its_circle() -> None:
    lamps = LineSensor(pitch_m=0.015)
    exact, shown = lap(LineSensor()), lap(lamps)

    assert np.abs(shown).max() == pytest.approx(np.abs(exact).max(), abs=lamps.pitch_m)
    assert np.abs(exact[3000:]).max() < 1e-4
    assert 1e-4 < np.abs(shown[3000:]).max() < 0.5 * lamps.pitch_m


def test_robot_that_has_lost_its_line_keeps_what_it_saw_last() -> None:
    rig = make_rig(CIRCLE, plant="B", line_sensor=LineSensor(0.001, 0.0005), **AT_ONCE)
    seen = [float(rig.drive(0.5, step=k)["y_seen"]) for k in range(500)]

    assert abs(rig.robots[0]["y_e"]) > 0.01  # the row of lamps ends at 3.75 mm
    assert abs(seen[-1]) == pytest.approx(0.0035)
    assert len(set(seen[-100:])) == 1
