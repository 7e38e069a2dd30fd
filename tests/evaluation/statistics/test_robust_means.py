from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import trim_mean

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    Statistic,
    crossed_draws,
    crossed_mean,
    each_once,
)
from hazbot_gym.evaluation.statistics.robust_means import (
    conditional_value_at_risk,
    interquartile_mean,
    quantile_mean,
)
from tests.evaluation.statistics.reference import plain_statistic

RUNS = st.lists(st.integers(-99, 99), min_size=1, max_size=30).map(
    lambda runs: np.array([runs], dtype=float)
)


def draw(seeds: int, scenarios: int) -> CrossedDraws:
    rng = np.random.default_rng(0)
    (draws,) = crossed_draws(np.zeros(scenarios), [seeds], rng, resamples=100)
    return draws


def of(statistic: Statistic, scores: Floats) -> float:
    draws = CrossedDraws(*(np.ones((1, size)) for size in scores.shape))
    return float(statistic(scores, draws)[0])


def test_interquartile_mean_is_scipys_and_that_of_the_middle_half() -> None:
    scores = np.random.default_rng(1).exponential(size=(4, 25))
    assert of(interquartile_mean, scores) == pytest.approx(trim_mean(scores, 0.25, axis=None))
    assert of(interquartile_mean, scores) == pytest.approx(np.sort(scores, axis=None)[25:75].mean())


def test_interquartile_mean_of_resamples_is_scipys() -> None:
    scores = np.random.default_rng(2).integers(0, 9, size=(4, 6)).astype(float)  # with ties
    written_out = plain_statistic(lambda runs: float(trim_mean(runs, 0.25)))(scores, draw(4, 6))
    np.testing.assert_allclose(interquartile_mean(scores, draw(4, 6)), written_out)


def test_runs_at_the_edge_count_in_part() -> None:
    # Of five runs the middle half is 2.5: all of the third, 3/4 of each neighbour.
    scores = np.array([[100.0, 1.0, 2.0, 4.0, -7.0]])
    assert of(interquartile_mean, scores) == pytest.approx((0.75 * 1 + 2 + 0.75 * 4) / 2.5)


def test_conditional_value_at_risk_by_hand() -> None:
    scores = np.array([[5.0, 1.0, 2.0, 9.0, 4.0], [8.0, 3.0, 7.0, 6.0, 10.0]])
    assert of(conditional_value_at_risk(0.2, worst="low"), scores) == pytest.approx(1.5)
    assert of(conditional_value_at_risk(0.2, worst="high"), scores) == pytest.approx(9.5)
    # A quarter of ten runs is the two worst and half of the third.
    assert of(conditional_value_at_risk(0.25, worst="low"), scores) == pytest.approx(4.5 / 2.5)


def test_one_outlier_moves_the_mean_but_not_the_interquartile_mean() -> None:
    scores = np.arange(20.0)[None]
    spoilt = np.where(scores == 19.0, 1e6, scores)
    assert of(interquartile_mean, spoilt) == of(interquartile_mean, scores)
    assert of(crossed_mean, spoilt) > 1e4


@given(RUNS)
def test_the_mean_of_all_levels_is_the_mean(scores: Floats) -> None:
    draws = draw(1, scores.shape[1])
    np.testing.assert_allclose(
        quantile_mean(0.0, 1.0)(scores, draws), crossed_mean(scores, draws), atol=1e-9
    )


@given(RUNS, st.sampled_from([0.05, 0.3, 0.5]))
def test_worst_ends_mirror_each_other(scores: Floats, alpha: float) -> None:
    low = of(conditional_value_at_risk(alpha, worst="low"), scores)
    high = of(conditional_value_at_risk(alpha, worst="high"), -scores)
    assert low == pytest.approx(-high, abs=1e-9)


@given(RUNS)
def test_a_smaller_share_of_the_worst_is_worse(scores: Floats) -> None:
    shares = [0.01, 0.1, 0.35, 1.0]
    tails = [of(conditional_value_at_risk(alpha, worst="low"), scores) for alpha in shares]
    assert (np.diff(tails) >= -1e-9).all()
    assert tails[0] == pytest.approx(scores.min())  # less than one run: that run
    assert tails[-1] == pytest.approx(scores.mean(), abs=1e-9)


def test_levels_that_enclose_nothing_are_refused() -> None:
    for low, high in ((0.5, 0.5), (0.75, 0.25), (-0.1, 0.5), (0.5, 1.1)):
        with pytest.raises(ValueError, match="levels"):
            quantile_mean(low, high)
    with pytest.raises(ValueError, match="levels"):
        conditional_value_at_risk(0.0, worst="low")


def test_the_data_are_one_resample_among_others() -> None:
    scores = np.random.default_rng(3).normal(size=(3, 8))
    draws = draw(3, 8)
    assert interquartile_mean(scores, each_once(draws)) == pytest.approx(
        [of(interquartile_mean, scores)]
    )
