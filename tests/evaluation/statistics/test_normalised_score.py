from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.evaluation.statistics.normalised_score import normalised_score


def test_the_constant_speed_is_0_and_the_optimum_1() -> None:
    assert normalised_score([-40.0, -10.0, -25.0, -70.0], -40.0, -10.0) == pytest.approx(
        [0.0, 1.0, 0.5, -1.0]
    )


def test_every_scenario_has_its_own_scale_for_all_seeds() -> None:
    scores = np.array([[1.0, 1.0], [2.0, 3.0]])
    shares = normalised_score(scores, [0.0, 1.0], [2.0, 5.0])
    np.testing.assert_allclose(shares, [[0.5, 0.0], [1.0, 0.5]])


def test_without_room_there_is_no_score() -> None:
    np.testing.assert_array_equal(
        normalised_score([1.0, 2.0], [1.0, 1.0], [1.0, 3.0]), [np.nan, 0.5]
    )
    assert np.isnan(normalised_score(1.0, 2.0, 2.0))


def test_the_unit_of_the_return_does_not_matter() -> None:
    j, low, top = np.array([3.0, 7.0]), 2.0, 9.0
    assert normalised_score(5 * j - 1, 5 * low - 1, 5 * top - 1) == pytest.approx(
        normalised_score(j, low, top)
    )
