from __future__ import annotations

import math

import numpy as np
import pytest

from hazbot_gym.core.sensor_ring import PAPER, SIX, RangeSensor, Sensors, ring_table

HALF_RAD = math.radians(15.0)


def test_sensors_of_the_paper_point_ahead_and_exactly_to_the_sides() -> None:
    table = ring_table(PAPER, HALF_RAD)

    cosine, sine = math.cos(HALF_RAD), math.sin(HALF_RAD)
    assert table["axis_x"] == pytest.approx([cosine, cosine, 0.0, 0.0], abs=1e-15)
    assert table["axis_y"] == pytest.approx([sine, -sine, 1.0, -1.0], abs=1e-15)
    assert table["axis_x"].tolist()[2:] == [0.0, 0.0]
    assert table["cos_half"] == pytest.approx([cosine] * 4, abs=1e-15)
    assert table["is_ahead"].tolist() == [1, 1, 0, 0]


def test_two_more_look_into_the_blind_sectors() -> None:
    low, high = math.radians(30.0), math.radians(75.0)  # between the cones of the paper's ring
    for sensor in SIX[len(PAPER) :]:
        assert low < abs(sensor.angle_rad) - HALF_RAD
        assert abs(sensor.angle_rad) + HALF_RAD < high
    assert SIX[: len(PAPER)] == PAPER
    assert ring_table(SIX, HALF_RAD)[:4].tolist() == ring_table(PAPER, HALF_RAD).tolist()


@pytest.mark.parametrize(
    ("sensors", "mirrors"),
    [
        (PAPER, [1, 0, 3, 2]),
        (SIX, [1, 0, 3, 2, 5, 4]),
        ((RangeSensor("alone", 1.0),), [0]),
        ((RangeSensor("a", 3.0), RangeSensor("b", 0.1), RangeSensor("c", 3.1)), [2, 2, 0]),
    ],
)
def test_cross_talk_comes_from_the_other_side(sensors: Sensors, mirrors: list[int]) -> None:
    assert ring_table(sensors, HALF_RAD)["mirror"].tolist() == mirrors


def test_a_sensor_may_have_a_cone_of_its_own() -> None:
    table = ring_table([RangeSensor("wide", 0.0, 0.5), RangeSensor("as_all", 1.0)], HALF_RAD)

    assert np.arctan2(table["sin_half"], table["cos_half"]) == pytest.approx([0.5, HALF_RAD])
