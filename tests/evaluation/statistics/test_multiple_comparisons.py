from __future__ import annotations

from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.evaluation.statistics.multiple_comparisons import holm

P_VALUES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12)


def test_holm_by_hand() -> None:
    # Sorted .005, .01, .03, .04 times 4, 3, 2, 1: .02, .03, .06, .04; the last may not be less
    # than the one before. statsmodels' multipletests(method="holm") and R's p.adjust say the same.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_a_family_of_one_needs_no_correction() -> None:
    assert holm([0.04]) == pytest.approx([0.04])
    assert len(holm([])) == 0


def test_a_comparison_that_could_not_be_made_still_belongs_to_the_family() -> None:
    np.testing.assert_allclose(holm([np.nan, 0.01, 0.02]), [np.nan, 0.03, 0.04])


@given(P_VALUES)
def test_holm_lies_between_no_correction_and_bonferroni(p_values: list[float]) -> None:
    p, adjusted = np.array(p_values), holm(p_values)
    assert (adjusted >= p).all()
    assert (adjusted <= np.minimum(1.0, len(p) * p)).all()
    assert (np.diff(adjusted[np.argsort(p)]) >= 0.0).all()


@given(P_VALUES, st.randoms())
def test_holm_does_not_depend_on_the_order(p_values: list[float], random: Random) -> None:
    order = random.sample(range(len(p_values)), len(p_values))
    np.testing.assert_array_equal(holm(np.array(p_values)[order]), holm(p_values)[order])


def test_holm_errs_in_a_family_as_seldom_as_one_test() -> None:
    p_values = np.random.default_rng(0).random((2000, 10))  # all hypotheses true
    errs = np.mean([(holm(family) <= 0.05).any() for family in p_values])
    assert errs == pytest.approx(0.05, abs=0.02)
    assert np.mean((p_values <= 0.05).any(axis=1)) > 0.3  # what it would be uncorrected
