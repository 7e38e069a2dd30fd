from __future__ import annotations

import math

import numpy as np
import pytest

from hazbot_gym.paper.sections.sensors.experiment import READINGS, TABLE_2, half_range, measure


def test_readings_are_right_in_the_mean_and_within_the_half_widths() -> None:
    found = measure(100)
    widths = (0.002, 0.03, 0.002)
    for column, errors, width in zip(found, found.errors(), widths, strict=True):
        assert len(column) == 100 * READINGS
        assert abs(errors.mean()) < 0.1 * width
        assert np.abs(errors).max() <= width
        assert half_range(errors) == pytest.approx(width, rel=0.03)


def test_printed_columns_are_swapped() -> None:
    _, angle, ultra = np.array(TABLE_2).T
    assert ultra.mean() == pytest.approx(math.pi / 2, abs=0.003)  # in radians: a right angle
    assert angle.mean() == pytest.approx(1.0, abs=0.01)  # the wall
