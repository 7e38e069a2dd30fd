from __future__ import annotations

import json
import math
from pathlib import Path

import numba
import pytest

from hazbot_gym.core.kinematics import (
    Chassis,
    Pose,
    Twist,
    arc_step,
    body_velocity,
    castor_angle,
    radius_from_castor,
    ratio_from_castor,
    turning_radius,
    wheel_ratio,
    wheel_speeds,
)

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "kinematics.json").read_text(encoding="utf-8")
)
CHASSIS = Chassis()
RADII_M = (0.05, 0.3, 1.17, 3.431, 50.0, -0.3, -3.431)


def test_robot_turns_in_place_when_wheels_oppose() -> None:
    velocity = body_velocity(1.0, -1.0, CHASSIS)

    assert velocity.v == 0.0
    assert velocity.omega == pytest.approx(2.0 * 0.2 / 0.438)


def test_robot_turns_left_when_the_right_wheel_is_faster() -> None:
    assert body_velocity(2.0, 1.0, CHASSIS).omega > 0.0


@pytest.mark.parametrize("velocity", [Twist(0.5, 0.0), Twist(0.5, 0.3), Twist(-0.2, -1.0)])
def test_wheel_speeds_invert_body_velocity(velocity: Twist) -> None:
    assert body_velocity(*wheel_speeds(velocity, CHASSIS), CHASSIS) == pytest.approx(velocity)


def test_circle_of_the_paper_has_its_yaw_rate_wheel_speeds_and_lap() -> None:
    circle, tolerance = REFERENCE["circle"], REFERENCE["circle_tolerance"]
    omega = circle["speed_mps"] / circle["radius_m"]
    w1, w2 = wheel_speeds(Twist(circle["speed_mps"], omega), CHASSIS)
    found = {
        "yaw_rate_radps": omega,
        "w1_radps": w1,
        "w2_radps": w2,
        "lap_s": 2.0 * math.pi / omega,
    }

    for name, value in found.items():
        assert value == pytest.approx(circle[name], abs=tolerance[name])


@pytest.mark.parametrize("row", REFERENCE["castor"])
def test_castor_angle_radius_and_ratio_agree_with_the_specification(row: dict[str, float]) -> None:
    tolerance = REFERENCE["castor_tolerance"]
    beta = math.radians(row["beta_deg"])

    assert radius_from_castor(beta, CHASSIS) == pytest.approx(
        row["radius_m"], abs=tolerance["radius_m"]
    )
    assert ratio_from_castor(beta, CHASSIS) == pytest.approx(row["ratio"], abs=tolerance["ratio"])
    assert math.degrees(castor_angle(row["radius_m"], CHASSIS)) == pytest.approx(
        row["beta_deg"], abs=0.01
    )


def test_castor_at_20_degrees_is_near_the_numbers_of_the_paper() -> None:
    paper = REFERENCE["paper"]
    beta = math.radians(paper["beta_deg"])

    relative = paper["tolerance_relative"]
    assert radius_from_castor(beta, CHASSIS) == pytest.approx(paper["radius_m"], rel=relative)
    assert ratio_from_castor(beta, CHASSIS) == pytest.approx(paper["ratio"], rel=relative)


@pytest.mark.parametrize("beta", [0.01, 0.35, 1.2, 1.5, -0.35])
def test_castor_ratio_is_the_wheel_ratio_of_its_radius(beta: float) -> None:
    radius = radius_from_castor(beta, CHASSIS)

    assert ratio_from_castor(beta, CHASSIS) == pytest.approx(wheel_ratio(radius, CHASSIS))


@pytest.mark.parametrize("beta", [1e-6, 0.01, 0.35, 1.2, 1.5, -0.35])
def test_castor_angle_inverts_the_radius(beta: float) -> None:
    radius = radius_from_castor(beta, CHASSIS)

    assert castor_angle(radius, CHASSIS) == pytest.approx(beta, rel=1e-9)


def test_castor_stands_across_when_the_robot_turns_about_a_nearer_point_than_its_trail() -> None:
    assert castor_angle(0.0, CHASSIS) == pytest.approx(math.pi / 2)
    assert castor_angle(0.04, CHASSIS) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("radius", RADII_M)
def test_turning_radius_inverts_wheel_ratio(radius: float) -> None:
    assert turning_radius(wheel_ratio(radius, CHASSIS), CHASSIS) == pytest.approx(radius)


def test_driving_straight_is_the_limit_of_an_infinite_radius() -> None:
    assert wheel_ratio(math.inf, CHASSIS) == 1.0
    assert turning_radius(1.0, CHASSIS) == math.inf
    assert radius_from_castor(0.0, CHASSIS) == math.inf
    assert castor_angle(math.inf, CHASSIS) == 0.0
    assert wheel_ratio(CHASSIS.L / 2.0, CHASSIS) == math.inf


def test_ratio_is_infinite_where_the_castor_makes_the_left_wheel_stand() -> None:
    beta = castor_angle(CHASSIS.L / 2.0, CHASSIS)

    assert abs(ratio_from_castor(beta, CHASSIS)) > 1e9


def test_arc_step_ends_on_the_circle() -> None:
    pose = arc_step(Pose(0.0, 0.0, 0.0), Twist(0.5, 0.5), math.pi)

    assert pose == pytest.approx(Pose(1.0, 1.0, math.pi / 2))


@pytest.mark.parametrize("omega", [0.0, 1e-9, 0.00199, 0.00201, 0.7, -0.7])
def test_one_long_arc_is_many_short_ones(omega: float) -> None:
    whole = arc_step(Pose(1.0, 2.0, 0.3), Twist(0.5, omega), 0.1)
    pose = Pose(1.0, 2.0, 0.3)
    for _ in range(100):
        pose = arc_step(pose, Twist(0.5, omega), 0.001)

    assert pose == pytest.approx(whole, abs=1e-13)


def test_compiled_arc_is_the_arc_of_plain_python() -> None:
    @numba.njit
    def compiled(x: float, omega: float) -> tuple[float, float, float]:
        pose = arc_step(Pose(x, 2.0, 0.3), Twist(0.5, omega), 0.1)
        return pose.x, pose.y, pose.theta

    for omega in (0.0, 1e-6, 1.3):
        assert compiled(1.0, omega) == pytest.approx(
            arc_step(Pose(1.0, 2.0, 0.3), Twist(0.5, omega), 0.1), abs=1e-15
        )
