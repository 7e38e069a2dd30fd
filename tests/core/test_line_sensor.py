from __future__ import annotations

import math

import numpy as np
import pytest

from hazbot_gym.core.line_sensor import LAMPS, LineSensor, seen_offset

SENSOR = LineSensor(pitch_m=0.015, line_m=0.02)
REACH_M = 3.5 * 0.015 + 0.01  # the outermost lamp stands over the line's edge


@pytest.mark.parametrize(
    ("y_e_m", "shown_m"),
    [
        (0.0, 0.0),  # the two lamps in the middle, at +-0.0075
        (0.002, 0.0),  # both still within 0.01 of it
        (0.003, 0.0075),  # -0.0075 is 0.0105 off: only the one at 0.0075
        (0.0075, 0.0075),
        (0.013, 0.015),  # 0.0075 and 0.0225
        (0.05, 0.0525),  # the outermost, the next ends at 0.0475
        (-0.03, -0.03),  # -0.0225 and -0.0375
        (0.0624, 0.0525),  # the line's edge is under the outermost lamp
    ],
)
def test_lit_lamps_by_hand(y_e_m: float, shown_m: float) -> None:
    assert seen_offset(y_e_m, math.nan, SENSOR) == pytest.approx(shown_m, abs=1e-12)


def by_counting(y_e_m: float, held_m: float, sensor: LineSensor) -> float:
    """Return the mean of the lit lamps, one by one as the docstring has it."""
    places = [(k - 3.5) * sensor.pitch_m for k in range(8)]
    lit = [place for place in places if abs(place - y_e_m) <= 0.5 * sensor.line_m]
    return sum(lit) / len(lit) if lit else held_m


@pytest.mark.parametrize("line_m", [0.005, 0.02, 0.05, 0.3])
def test_middle_of_first_and_last_is_the_mean_of_the_lit(line_m: float) -> None:
    sensor = LineSensor(0.015, line_m)
    for y_e_m in np.random.default_rng(1).uniform(-0.3, 0.3, 500):
        expected = by_counting(y_e_m, 7.0, sensor)
        assert seen_offset(y_e_m, 7.0, sensor) == pytest.approx(expected, abs=1e-12)


def test_what_is_shown_on_one_side_is_shown_on_the_other_with_opposite_sign() -> None:
    for y_e_m in np.random.default_rng(2).uniform(0.0, REACH_M, 300):
        left, right = (seen_offset(sign * y_e_m, math.nan, SENSOR) for sign in (1.0, -1.0))
        assert left == pytest.approx(-right, abs=1e-15)


def test_a_line_that_lights_one_lamp_or_two_has_fifteen_states() -> None:
    shown = {
        round(seen_offset(y, math.nan, SENSOR), 9)
        for y in np.linspace(-REACH_M, REACH_M, 9999)[1:-1]
    }
    assert len(shown) == LAMPS + (LAMPS - 1)
    assert np.diff(sorted(shown)) == pytest.approx(SENSOR.pitch_m / 2)


def test_a_line_that_no_lamp_sees_is_where_it_was_seen_last() -> None:
    assert seen_offset(REACH_M + 1e-6, 0.0525, SENSOR) == 0.0525
    assert seen_offset(-5.0, -0.0525, SENSOR) == -0.0525
    between = LineSensor(pitch_m=0.015, line_m=0.002)  # narrower than the gap
    assert seen_offset(0.0, 0.0075, between) == 0.0075
