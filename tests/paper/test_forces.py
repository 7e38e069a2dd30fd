from __future__ import annotations

import pytest

from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce
from hazbot_gym.core.state import ROBOT_MASS_KG
from hazbot_gym.paper.sections.social_force.experiment import (
    HUMAN,
    ROBOT,
    drawn,
    forces_on,
    repulsion_mps2,
)


def test_force_towards_the_desired_speed_is_mass_times_lack_over_relaxation_time() -> None:
    lack_mps = ROBOT.desired_vx - ROBOT.vx
    force = forces_on(ROBOT, HUMAN, 0.0).acceleration
    assert force == pytest.approx((ROBOT_MASS_KG * lack_mps / 0.5, 0.0))


def test_total_is_the_sum_of_the_three() -> None:
    _, forces = drawn()["human"]
    for axis in (0, 1):
        assert forces.total[axis] == pytest.approx(sum(term[axis] for term in forces))
        assert forces.total[axis] != forces.acceleration[axis]


def test_the_two_push_each_other_apart_and_the_curious_one_is_drawn_nearer() -> None:
    robot, human = drawn()["robot"][1], drawn()["human"][1]
    assert robot.interaction[1] < 0.0 < human.interaction[1]  # the human is on the left
    assert robot.attraction == (0.0, 0.0)
    assert human.attraction[0] < 0.0
    assert human.attraction[1] < 0.0


def test_published_repulsion_reaches_farther_than_the_calibrated_one() -> None:
    for clearance_m in (0.1, 0.5, 1.0):
        assert repulsion_mps2(clearance_m, HELBING_MOLNAR_1995) > repulsion_mps2(
            clearance_m, SocialForce()
        )
    assert repulsion_mps2(0.6, HELBING_MOLNAR_1995) == pytest.approx(7.0 * 2.718281828**-2.0)
