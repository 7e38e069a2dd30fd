from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.ssm import SsmThresholds, permitted_speed, protective_distance

# a, T_r: S_p(0.5 m/s), and v_max at clearances of 1.2, 2.0, 3.6 m for v_h = 1.6 and 1.2 m/s:
# computed apart from this code from the formula of ISO/TS 15066.
TABLE = [
    ((1.0, 0.1), 1.69, (0.27, 0.64, 1.24), (0.36, 0.79, 1.45)),
    ((1.0, 0.3), 2.11, (0.09, 0.46, 1.06), (0.18, 0.60, 1.26)),
    ((0.5, 0.1), 2.61, (0.14, 0.35, 0.72), (0.20, 0.45, 0.87)),
]


@pytest.mark.parametrize(("drive", "distance", "strict", "slower"), TABLE)
def test_the_formula_gives_the_known_table(
    drive: tuple[float, float],
    distance: float,
    strict: tuple[float, ...],
    slower: tuple[float, ...],
) -> None:
    ssm = SsmThresholds(braking_mps2=drive[0], reaction_s=drive[1])
    assert protective_distance(np.array(0.5), ssm) == pytest.approx(distance, abs=0.006)
    for approach_mps, speeds in ((1.6, strict), (1.2, slower)):
        found = permitted_speed([1.2, 2.0, 3.6], ssm, np.full(3, approach_mps))
        assert found == pytest.approx(speeds, abs=0.006)


@given(st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_the_permitted_speed_is_the_inverse_of_the_distance(v: float, approach_mps: float) -> None:
    ssm = SsmThresholds(approach_mps=approach_mps)
    distance = protective_distance(np.array(v), ssm)
    assert permitted_speed(distance, ssm) == pytest.approx(v, abs=1e-7)


def test_below_the_distance_of_a_standing_robot_nothing_is_permitted() -> None:
    ssm = SsmThresholds()
    nearest = float(protective_distance(np.array(0.0), ssm))
    assert permitted_speed([0.0, nearest - 1e-9], ssm).tolist() == [0.0, 0.0]
    assert permitted_speed(nearest + 0.01, ssm) > 0.0
