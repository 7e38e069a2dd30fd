"""The part of the ROS 2 example that needs no ROS."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace as Message
from typing import Any

import pytest

from hazbot_gym import SpeedController

FILE = Path(__file__).parents[2] / "examples" / "ros2_speed_node.py"
NAMES = ("front_left", "front_right", "left", "right")


@pytest.fixture(scope="module")
def node() -> Any:
    spec = importlib.util.spec_from_file_location("ros2_speed_node", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def odometry(x: float, y: float, yaw: float, v: float) -> Message:
    turn = Message(w=math.cos(yaw / 2.0), z=math.sin(yaw / 2.0))
    pose = Message(pose=Message(position=Message(x=x, y=y), orientation=turn))
    twist = Message(twist=Message(linear=Message(x=v), angular=Message(z=0.1)))
    return Message(pose=pose, twist=twist)


def path(*points: tuple[float, float]) -> Message:
    return Message(poses=[Message(pose=Message(position=Message(x=x, y=y))) for x, y in points])


def heard(node: Any, *, has_people: bool) -> Any:
    inputs = node.Inputs(NAMES, has_people=has_people)
    for name in NAMES:
        inputs.hear_range(name, Message(range=1.5, max_range=4.0), 10.0)
    inputs.hear_odometry(odometry(1.0, 0.1, 0.0, 0.4), 9.9)
    inputs.hear_path(path((0.0, 0.0), (0.0, 0.0), (12.0, 0.0)))
    return inputs


def test_a_controller_drives_on_the_messages(node: Any) -> None:
    controller = SpeedController("constant", tier="sonar", clock=lambda: 0.0)
    inputs = heard(node, has_people=False)

    assert controller.step(**inputs.readings(10.05)) == 0.5
    assert controller.step(**inputs.readings(10.3)) == 0.0  # odometry is 0.4 s old
    assert controller.stop is not None
    assert controller.stop.cause == "stale"


@pytest.mark.parametrize("missing", ["people", "path", "range"])
def test_without_a_topic_the_robot_stands(node: Any, missing: str) -> None:
    controller = SpeedController("constant", tier="tracks", clock=lambda: 0.0)
    inputs = heard(node, has_people=True)
    if missing != "people":
        inputs.hear_people(Message(people=[]), 10.0)
        assert controller.step(**inputs.readings(10.0)) == 0.5
    if missing == "path":
        inputs.hear_path(path())
    if missing == "range":
        inputs.hear_range("left", Message(range=math.nan, max_range=4.0), 10.0)
    assert controller.step(**inputs.readings(10.0)) == 0.0


def test_people_are_turned_into_the_robot_s_frame(node: Any) -> None:
    inputs = heard(node, has_people=True)
    inputs.hear_odometry(odometry(1.0, 2.0, math.pi / 2.0, 0.4), 10.0)
    one = Message(name="7", position=Message(x=0.0, y=5.0), velocity=Message(x=0.0, y=-1.2))
    inputs.hear_people(Message(people=[one]), 10.0)
    (person,) = inputs.readings(10.0)["people"]

    assert person.pop("track") == "7"
    expected = {"x_m": 3.0, "y_m": 1.0, "vx_mps": -1.2, "vy_mps": 0.0}
    assert person == pytest.approx(expected, abs=1e-12)


def test_fields_of_the_path_are_those_of_the_nearest_point(node: Any) -> None:
    corner = [(0.0, 0.0), (5.0, 0.0), (5.0, 4.0)]
    route = heard(node, has_people=False)
    route.hear_path(path(*corner))
    found = node.along(route.route, (4.0, 0.2, 0.1))

    assert found["y_e_m"] == pytest.approx(0.2)
    assert found["theta_e_rad"] == pytest.approx(0.1)
    assert found["remaining_m"] == pytest.approx(5.0)
    assert found["curvature_ahead_per_m"] == pytest.approx(math.pi / 2.0 / 0.5)
    assert node.along(route.route, (5.1, 3.0, math.pi / 2.0))["y_e_m"] == pytest.approx(-0.1)


def test_a_range_beyond_the_sensor_s_is_no_echo(node: Any) -> None:
    inputs = heard(node, has_people=False)
    inputs.hear_range("left", Message(range=4.5, max_range=4.0), 10.0)
    assert inputs.readings(10.0)["ranges_m"]["left"] == math.inf
