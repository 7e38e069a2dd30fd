from __future__ import annotations

import math
from pathlib import Path

import pytest

from hazbot_gym.core.sensor_ring import SIX
from hazbot_gym.runtime.robot_file import Robot, check_agreement, load_robot, simulated_robot
from tests.refusals import refused

SENSORS = """
sensors:
  - {name: front_left, x_m: 0.29, y_m: 0.078, yaw_rad: 0.2618}
  - {name: front_right, x_m: 0.29, y_m: -0.078, yaw_rad: -0.2618}
  - {name: left, x_m: 0.0, y_m: 0.3, yaw_rad: 1.5708}
  - {name: right, x_m: 0.0, y_m: -0.3, yaw_rad: -1.5708}
"""


def robot_in(folder: Path, text: str) -> Robot:
    file = folder / "robot.yaml"
    file.write_text(text)
    return load_robot(file)


def test_defaults_are_the_simulator_s() -> None:
    check_agreement(Robot(), simulated_robot("paper"), "ppo")
    assert [each.name for each in simulated_robot("six").sensors] == [each.name for each in SIX]


def test_a_robot_that_is_nearly_the_simulated_one_agrees(tmp_path: Path) -> None:
    robot = robot_in(tmp_path, f"nominal_speed_mps: 0.5\ndeceleration_mps2: 2.0\n{SENSORS}")
    check_agreement(robot, simulated_robot("paper"), "ppo")
    assert robot.ring[0].angle_rad == 0.2618


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nominal_speed_mps: 0.8", "robot.nominal_speed_mps ... 0.8 ... 0.5"),
        ("decision_period_s: 0.05", "robot.decision_period_s ... 0.05 ... 0.1"),
        ("deceleration_mps2: 0.5", "robot.deceleration_mps2 ... 0.5 ... 1"),
        (SENSORS.replace("0.2618", "0.4", 1), "robot.sensors.front_left.yaw_rad ... 0.4 ... 0.26"),
        (SENSORS.replace("x_m: 0.0", "x_m: 0.2", 1), "robot.sensors.left.x_m ... 0.2 ... 0"),
        (
            SENSORS.replace("1.5708}", "1.5708, half_cone_rad: 0.5}", 1),
            "left.half_cone_rad ... 0.5",
        ),
        ("sensors: [{name: ahead, x_m: 0.3, y_m: 0.0, yaw_rad: 0.0}]", "number ... 1 ... 4"),
    ],
)
def test_a_robot_of_another_make_is_refused(tmp_path: Path, text: str, said: str) -> None:
    robot = robot_in(tmp_path, text)
    with refused(said):
        check_agreement(robot, simulated_robot("paper"), "ppo")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nominal_speed: 0.5", "nominal_speed ... nominal_speed_mps"),
        ("nominal_speed_mps: fast", "nominal_speed_mps ... 'fast'"),
        ("sensors: []", "sensors"),
        (SENSORS.replace("name: left", "name: front_left"), "front_left"),
        (SENSORS.replace("yaw_rad: 1.5708", "yaw_rad: 90"), "yaw_rad ... 90"),
        (SENSORS.replace("front_left", "bow"), "bow ... front_left"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(tmp_path: Path, text: str, said: str) -> None:
    with refused(f"robot ... {said}"):
        robot_in(tmp_path, text)


def test_directions_are_compared_around_the_circle() -> None:
    behind = simulated_robot("paper").sensors[0].model_copy(update={"yaw_rad": math.pi})
    other = behind.model_copy(update={"yaw_rad": -math.pi})
    robot = Robot().model_copy(update={"sensors": (behind,)})
    check_agreement(robot, Robot().model_copy(update={"sensors": (other,)}), "ppo")
