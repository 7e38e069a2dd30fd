from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from hazbot_gym.core.kinematics import radius_from_castor
from hazbot_gym.paper.sections.kinematics.experiment import CHASSIS, castor_table, nearest_chassis_m

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "kinematics.json").read_text(encoding="utf-8")
)


def test_each_of_the_paper_s_numbers_gives_the_other_two_of_the_specification() -> None:
    within = REFERENCE["castor_tolerance"]
    for turn, known in zip(castor_table(), REFERENCE["castor"], strict=False):
        assert math.degrees(turn.beta_rad) == pytest.approx(
            known["beta_deg"], abs=within["beta_deg"]
        )
        assert turn.radius_m == pytest.approx(known["radius_m"], abs=within["radius_m"])
        assert turn.ratio == pytest.approx(known["ratio"], abs=within["ratio"])


def test_other_readings_are_farther_off_or_excluded() -> None:
    *_, cosine, half = castor_table()
    assert cosine.radius_m == pytest.approx(1.1793, abs=1e-4)
    assert half.ratio == pytest.approx(2.157, abs=1e-3)


def test_the_length_that_would_fit_gives_the_paper_s_radius() -> None:
    chassis = CHASSIS._replace(L1=nearest_chassis_m())
    assert radius_from_castor(math.radians(20.0), chassis) == pytest.approx(1.17, abs=1e-9)
    assert nearest_chassis_m() < CHASSIS.L1
