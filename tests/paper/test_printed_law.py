from __future__ import annotations

import pytest

from hazbot_gym.paper.sections.circle.experiment import drive_lap, paper_drive
from hazbot_gym.paper.sections.fuzzy_pid.experiment import LAWS, left_over

# The earlier prototype, plant A (docs/paper.md, section 3.3). How it took the rates of the error is
# not known; ours are of the last step's velocity, and leave 4 mm less.
PROTOTYPE = {"(12c)": 0.0, "measured": 0.094, "rates": 0.086, "positions": 0.029}


@pytest.mark.parametrize("law", LAWS)
def test_the_printed_law_leaves_a_position_error_and_no_angle_error(law: str) -> None:
    left = left_over(law)
    assert left.position_m == pytest.approx(PROTOTYPE[law], abs=0.005)
    assert left.angle_rad < 0.001


def test_the_corrected_law_is_the_one_that_the_robot_drives_by() -> None:
    lap = drive_lap(paper_drive(plant="A"))
    left = left_over("(12c)")
    assert left.position_m == pytest.approx(lap.position_m[-1], abs=1e-5)
