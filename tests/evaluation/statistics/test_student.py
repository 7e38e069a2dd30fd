from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm, ttest_1samp, ttest_ind
from scipy.stats import t as student

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.intervals import percentile_interval, scenario_draws
from hazbot_gym.evaluation.statistics.student import (
    precision,
    student_interval,
    student_p_value,
    t_quantile,
    t_tail,
)

RNG = np.random.default_rng(0)


def every_resample(seeds: int) -> Floats:
    """Return the counts of all resamples of some seeds, each as often as it can be drawn."""
    drawn = np.array(list(itertools.product(range(seeds), repeat=seeds)))
    counts: Floats = (drawn[:, :, None] == np.arange(seeds)).sum(axis=1).astype(float)
    return counts


def test_standard_error_of_seeds_is_that_of_the_t_test() -> None:
    scores, counts = RNG.normal(size=5), every_resample(5)
    resampled = counts @ scores / 5
    inflation, freedom = precision(resampled, [counts])
    assert freedom == pytest.approx(4.0)
    assert inflation * resampled.std() == pytest.approx(scores.std(ddof=1) / math.sqrt(5))


def test_two_policies_have_the_freedom_of_welch() -> None:
    ours, theirs = RNG.normal(size=4), RNG.normal(scale=3.0, size=3)
    pairs = itertools.product(every_resample(4), every_resample(3))
    ours_drawn, theirs_drawn = (np.array(side) for side in zip(*pairs, strict=True))
    resampled = ours_drawn @ ours / 4 - theirs_drawn @ theirs / 3
    inflation, freedom = precision(resampled, [ours_drawn, theirs_drawn])
    welch = ttest_ind(ours, theirs, equal_var=False)
    error = (ours.mean() - theirs.mean()) / welch.statistic
    assert freedom == pytest.approx(welch.df)
    assert inflation * resampled.std() == pytest.approx(error)


@pytest.mark.parametrize("freedom", [1.0, 2.5, 9.0, math.inf])
def test_quantiles_and_tails_are_scipys(freedom: float) -> None:
    assert t_quantile(0.975, freedom) == pytest.approx(student.ppf(0.975, freedom))
    assert t_tail(1.5, freedom) == pytest.approx(student.sf(1.5, freedom))


def test_one_row_keeps_the_percentiles_of_its_scenarios() -> None:
    draws = scenario_draws(np.zeros(40), np.random.default_rng(1))
    resampled = draws @ RNG.exponential(size=40) / 40
    plain = percentile_interval(1.0, resampled)
    assert student_interval(1.0, resampled, [np.ones((2000, 1))]) == pytest.approx(plain)


def test_undefined_resamples_do_not_count() -> None:
    scores, counts = RNG.normal(size=5), every_resample(5)
    resampled = counts @ scores / 5
    some = np.arange(len(resampled)) % 7 == 0
    known = student_interval(0.1, resampled[~some], [counts[~some]])
    resampled[some] = np.nan
    assert student_interval(0.1, resampled, [counts]) == pytest.approx(known)


def test_p_value_of_normal_scores_is_about_that_of_the_t_test() -> None:
    scores, rng = np.random.default_rng(3).normal(0.4, 1.0, 10), np.random.default_rng(4)
    counts = rng.multinomial(10, np.full(10, 0.1), size=20_000).astype(float)
    p = student_p_value(float(scores.mean()), counts @ scores / 10, [counts])
    assert p == pytest.approx(ttest_1samp(scores, 0.0).pvalue, rel=0.2)


def test_p_value_has_no_floor_of_resamples() -> None:
    resampled = np.random.default_rng(5).normal(10.0, 1.0, size=999)
    p = student_p_value(10.0, resampled, [])
    assert p < 1e-10
    assert p == pytest.approx(2.0 * norm.sf(10.0), rel=10.0, abs=0.0)


@given(st.floats(-3.0, 3.0), st.sampled_from([0.8, 0.95]))
def test_the_test_and_the_interval_say_the_same(shift: float, confidence: float) -> None:
    counts = every_resample(4)
    resampled = counts @ (np.array([0.0, 1.0, 1.5, 4.0]) - 1.625) / 4 + shift
    _, low, high = student_interval(shift, resampled, [counts], confidence=confidence)
    p = student_p_value(shift, resampled, [counts], confidence=confidence)
    assert (p < 1.0 - confidence) == (not low <= 0.0 <= high) or abs(p - 1.0 + confidence) < 1e-9


def test_no_difference_and_no_data_are_no_evidence() -> None:
    assert student_p_value(0.0, np.zeros(99), []) == 1.0
    assert student_p_value(-0.5, np.full(99, -0.5), []) == 0.0
    assert math.isnan(student_p_value(0.0, np.full(99, np.nan), []))


def test_policies_that_do_not_differ_are_told_apart_as_seldom_as_promised() -> None:
    rng = np.random.default_rng(2)
    draws = scenario_draws(np.zeros(80), rng, resamples=1000)
    scores = [rng.exponential(size=80) - 1.0 for _ in range(500)]
    p_values = [student_p_value(float(x.mean()), draws @ x / 80, []) for x in scores]
    assert np.mean(np.array(p_values) <= 0.05) == pytest.approx(0.05, abs=0.03)
