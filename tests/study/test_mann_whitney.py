from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from hazbot_gym.study.crossed_bootstrap import CrossedDraws, crossed_draws, crossed_estimate
from hazbot_gym.study.mann_whitney import unpaired_improvement
from hazbot_gym.study.paired_scores import improvements, pair_draws


def draw_two(ours: int, theirs: int, scenarios: int) -> list[CrossedDraws]:
    return crossed_draws(
        np.zeros(scenarios), [ours, theirs], np.random.default_rng(0), resamples=300
    )


def test_probability_of_improvement_is_mann_whitneys_u_per_pair_of_runs() -> None:
    rng = np.random.default_rng(1)
    ours, theirs = rng.integers(0, 6, size=(3, 15)), rng.integers(0, 7, size=(2, 15))  # with ties
    value, low, high = unpaired_improvement(ours, theirs, *draw_two(3, 2, 15))
    u = mannwhitneyu(ours.ravel(), theirs.ravel()).statistic
    assert value == pytest.approx(u / (ours.size * theirs.size))
    assert 0.0 <= low < value < high <= 1.0


def test_a_resample_is_mann_whitneys_u_of_its_runs_written_out() -> None:
    rng = np.random.default_rng(2)
    ours = rng.integers(0, 6, size=(3, 8)).astype(float)
    theirs = rng.integers(0, 7, size=(2, 8)).astype(float)
    ours[0, :4] = theirs[1, 2] = np.nan
    for resample in range(5):
        draws = [
            CrossedDraws(*(counts[resample : resample + 1] for counts in both))
            for both in draw_two(3, 2, 8)
        ]
        x, y = (
            scores.repeat(seeds[0].astype(int), axis=0).repeat(scenarios[0].astype(int), axis=1)
            for scores, (seeds, scenarios) in zip((ours, theirs), draws, strict=True)
        )
        estimate = unpaired_improvement(ours, theirs, *draws)
        x, y = x[~np.isnan(x)], y[~np.isnan(y)]
        u = mannwhitneyu(x, y).statistic
        assert estimate.low == estimate.high == pytest.approx(u / (x.size * y.size))


def test_exchanging_the_policies_mirrors_the_estimate() -> None:
    rng = np.random.default_rng(3)
    ours, theirs = rng.normal(0.3, 1.0, size=(2, 20)), rng.normal(size=(4, 20))
    our_draws, their_draws = draw_two(2, 4, 20)
    value, low, high = unpaired_improvement(ours, theirs, our_draws, their_draws)
    mirrored = unpaired_improvement(theirs, ours, their_draws, our_draws)
    assert mirrored == pytest.approx((1 - value, 1 - high, 1 - low))


def test_infinite_scores_count_and_missing_ones_do_not() -> None:
    one = draw_two(1, 1, 3)
    assert unpaired_improvement([np.inf, np.nan, 1.0], [0.0, np.inf, np.nan], *one).mean == (
        pytest.approx((1.0 + 0.5 + 1.0 + 0.0) / 4)
    )
    assert np.isnan(unpaired_improvement([np.nan] * 3, [1.0] * 3, *one)).all()


def test_pairing_tells_apart_what_hard_and_easy_scenarios_hide() -> None:
    rng = np.random.default_rng(4)
    difficulty = rng.normal(0.0, 10.0, size=100)
    ours, theirs = difficulty + 1.0, difficulty
    draws = draw_two(1, 1, 100)
    assert unpaired_improvement(ours, theirs, *draws).mean < 0.6
    assert crossed_estimate(improvements(ours, theirs), pair_draws(*draws)) == (1.0, 1.0, 1.0)
