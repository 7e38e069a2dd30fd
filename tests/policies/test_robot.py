from __future__ import annotations

from hazbot_gym.config import Config
from hazbot_gym.policies import robot


def test_rules_take_the_robot_for_what_it_is() -> None:
    drive, clock = Config().drive, Config().clock
    assert drive.nominal_speed_mps == robot.NOMINAL_MPS
    assert drive.acceleration_mps2 == robot.ACCELERATION_MPS2
    assert drive.deceleration_mps2 == robot.BRAKING_MPS2
    assert clock.decision_s == robot.DECISION_S
