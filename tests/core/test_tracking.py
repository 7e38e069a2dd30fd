from __future__ import annotations

import math

import numpy as np
import pytest

from hazbot_gym.core.kinematics import Pose, Twist, arc_step
from hazbot_gym.core.tracking import (
    TrackingGains,
    pose_error,
    pose_error_rate,
    printed_tracking_law,
    tracking_law,
)

GAINS = TrackingGains()


def random_states(count: int = 200) -> list[tuple[Pose, Pose, Twist, Twist]]:
    """Return random robot poses, reference poses, and the velocities of both."""
    rng = np.random.default_rng(1)
    draw = rng.uniform(-1.0, 1.0, (count, 10)) * [3, 3, 3.1, 3, 3, 3.1, 1, 2, 1, 2]
    return [(Pose(*row[:3]), Pose(*row[3:6]), Twist(*row[6:8]), Twist(*row[8:])) for row in draw]


def test_robot_ahead_and_left_of_its_reference_has_positive_errors() -> None:
    error = pose_error(Pose(1.2, 2.1, 0.0), Pose(1.0, 2.0, 0.1))

    assert error == pytest.approx(Pose(0.2, 0.1, -0.1))


def test_error_is_measured_in_the_frame_of_the_robot() -> None:
    error = pose_error(Pose(0.0, 1.0, math.pi / 2), Pose(0.0, 0.0, math.pi / 2))

    assert error == pytest.approx(Pose(1.0, 0.0, 0.0))


def test_heading_error_is_the_short_way_round() -> None:
    error = pose_error(Pose(0.0, 0.0, 3.1), Pose(0.0, 0.0, -3.1))

    assert error.theta == pytest.approx(6.2 - 2.0 * math.pi)


def test_error_rate_is_the_derivative_of_the_error() -> None:
    h = 1e-5
    for pose, reference, velocity, reference_velocity in random_states():
        error = pose_error(pose, reference)
        after, before = (
            pose_error(arc_step(pose, velocity, t), arc_step(reference, reference_velocity, t))
            for t in (h, -h)
        )
        difference = (np.array(after) - np.array(before)) / (2.0 * h)
        if abs(error.theta) < 3.0:  # elsewhere the heading error may wrap between the two
            assert pose_error_rate(error, velocity, reference_velocity) == pytest.approx(
                tuple(difference), abs=1e-6
            )


def test_lyapunov_function_never_grows_under_the_corrected_law() -> None:
    for pose, reference, _, reference_velocity in random_states():
        error = pose_error(pose, reference)
        forward = Twist(abs(reference_velocity.v), reference_velocity.omega)
        rate = pose_error_rate(error, tracking_law(error, forward, GAINS), forward)
        growth = error.x * rate.x + error.y * rate.y
        growth += math.sin(error.theta) * rate.theta / abs(GAINS.a2)
        expected = GAINS.a1 * error.x**2 + GAINS.a3 / abs(GAINS.a2) * math.sin(error.theta) ** 2
        assert growth <= 1e-12
        assert growth == pytest.approx(expected, abs=1e-12)


def test_law_passes_the_reference_on_when_there_is_no_error() -> None:
    assert tracking_law(Pose(0.0, 0.0, 0.0), Twist(0.5, 0.2), GAINS) == Twist(0.5, 0.2)


def test_robot_left_of_its_path_steers_right() -> None:
    assert tracking_law(Pose(0.0, 0.1, 0.0), Twist(0.5, 0.0), GAINS).omega < 0.0


def test_printed_law_leaves_a_position_error_and_the_corrected_one_removes_it() -> None:
    def final_error(is_corrected: bool) -> float:
        pose, reference, twist = Pose(-0.1, 0.1, 0.0), Pose(0.0, 0.0, 0.0), Twist(0.5, 0.0)
        velocity = twist
        for _ in range(4000):
            error = pose_error(pose, reference)
            if is_corrected:
                velocity = tracking_law(error, twist, GAINS)
            else:
                difference = Twist(velocity.v - twist.v, velocity.omega - twist.omega)
                velocity = printed_tracking_law(error.theta, difference, twist, GAINS)
            pose = arc_step(pose, velocity, 0.01)
            reference = arc_step(reference, twist, 0.01)
        return math.hypot(pose.x - reference.x, pose.y - reference.y)

    assert final_error(is_corrected=True) < 1e-3
    assert final_error(is_corrected=False) > 0.1


def test_printed_law_is_the_paper_s_by_hand() -> None:
    velocity = printed_tracking_law(0.3, Twist(0.1, -0.2), Twist(0.5, 0.2), GAINS)

    assert velocity.v == pytest.approx(0.5 * math.cos(0.3) - 0.1)
    assert velocity.omega == pytest.approx(0.2 - 0.6 * math.sin(0.3) + 0.1)
