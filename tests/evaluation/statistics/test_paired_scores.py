from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    crossed_draws,
    crossed_estimate,
    crossed_mean,
)
from hazbot_gym.evaluation.statistics.intervals import bootstrap_mean
from hazbot_gym.evaluation.statistics.paired_scores import differences, improvements, pair_draws


def draw_two(ours: int, theirs: int, scenarios: int) -> list[CrossedDraws]:
    return crossed_draws(
        np.zeros(scenarios), [ours, theirs], np.random.default_rng(0), resamples=300
    )


def test_every_seed_of_ours_meets_every_seed_of_theirs() -> None:
    ours, theirs = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[1.0, 1.0], [0.0, 4.0]])
    assert differences(ours, theirs).tolist() == [[0, 1], [1, -2], [2, 3], [3, 0]]
    assert improvements(ours, theirs).tolist() == [[0.5, 1], [1, 0], [1, 1], [1, 0.5]]


def test_resampled_difference_is_the_difference_of_resampled_means() -> None:
    rng = np.random.default_rng(1)
    ours, theirs = rng.normal(size=(4, 12)), rng.normal(size=(3, 12))
    our_draws, their_draws = draw_two(4, 3, 12)
    np.testing.assert_allclose(
        crossed_mean(differences(ours, theirs), pair_draws(our_draws, their_draws)),
        crossed_mean(ours, our_draws) - crossed_mean(theirs, their_draws),
        atol=1e-12,
    )


def test_two_policies_of_one_seed_differ_as_paired_over_scenarios() -> None:
    rng = np.random.default_rng(2)
    ours, theirs = rng.normal(size=30), rng.normal(size=30)
    ours[:3] = np.nan
    theirs[2:6] = np.inf
    draws = pair_draws(*draw_two(1, 1, 30))
    assert crossed_estimate(differences(ours, theirs), draws) == pytest.approx(
        bootstrap_mean(ours - theirs, draws.scenarios), rel=1e-12
    )


@pytest.mark.parametrize(("compare", "truth"), [(differences, 0.0), (improvements, 0.5)])
def test_policies_alike_are_compared_as_surely_as_promised(
    compare: Callable[[Floats, Floats], Floats], truth: float
) -> None:
    rng = np.random.default_rng(5)
    draws = pair_draws(*crossed_draws(np.zeros(100), [8, 8], rng, resamples=600))

    def scores(difficulty: Floats) -> Floats:
        """Scores of a policy with its own effect of seed, of seed in scenario, and of scenario."""
        own = rng.normal(0.0, 0.1, (8, 1)) + rng.normal(0.0, 0.2, 100)
        return difficulty + own + rng.normal(0.0, 0.3, (8, 100))

    covered = []
    for _ in range(300):
        difficulty = rng.normal(0.0, 0.5, 100)
        ours, theirs = scores(difficulty), scores(difficulty)
        _, low, high = crossed_estimate(compare(ours, theirs), draws)
        covered.append(low <= truth <= high)
    assert 0.88 <= np.mean(covered) <= 0.99


def test_infinite_on_both_sides_has_no_difference_but_is_a_tie() -> None:
    ours = [np.inf, np.inf, 1.0, np.nan, 1.0]
    theirs = [np.inf, 1.0, np.inf, 1.0, np.nan]
    assert np.isfinite(differences(ours, theirs)).tolist() == [[False] * 5]
    np.testing.assert_array_equal(improvements(ours, theirs), [[0.5, 1.0, 0.0, np.nan, np.nan]])


def test_a_policy_does_not_differ_from_itself() -> None:
    scores = np.random.default_rng(3).normal(size=(4, 20))
    ours, _ = draw_two(4, 4, 20)
    draws = pair_draws(ours, ours)
    assert crossed_estimate(differences(scores, scores), draws) == pytest.approx((0, 0, 0))
    assert crossed_estimate(improvements(scores, scores), draws).mean == pytest.approx(0.5)


def test_probability_of_improvement_is_the_average_of_mann_whitney_over_scenarios() -> None:
    rng = np.random.default_rng(4)
    ours, theirs = rng.integers(0, 4, size=(5, 20)), rng.integers(0, 5, size=(7, 20))  # with ties
    u = mannwhitneyu(ours, theirs, axis=0).statistic
    draws = pair_draws(*draw_two(5, 7, 20))
    value, low, high = crossed_estimate(improvements(ours, theirs), draws)
    assert value == pytest.approx(np.mean(u / (5 * 7)))
    assert 0.0 <= low < value < high <= 1.0


MATRICES = st.lists(st.lists(st.integers(0, 3), min_size=4, max_size=4), min_size=1, max_size=3)


@given(MATRICES, MATRICES)
def test_either_is_better_or_it_is_a_tie(ours: list[list[int]], theirs: list[list[int]]) -> None:
    total = improvements(ours, theirs).mean() + improvements(theirs, ours).mean()
    assert total == pytest.approx(1.0)


@given(MATRICES, MATRICES)
def test_only_the_order_of_scores_decides(ours: list[list[int]], theirs: list[list[int]]) -> None:
    def warped(scores: list[list[int]]) -> Floats:
        return np.exp(np.array(scores, dtype=float))

    np.testing.assert_array_equal(
        improvements(warped(ours), warped(theirs)), improvements(ours, theirs)
    )


def test_what_is_not_paired_is_refused() -> None:
    with pytest.raises(ValueError, match="3 and 4"):
        differences(np.zeros((2, 3)), np.zeros(4))
    ours, _ = draw_two(2, 2, 5)
    apart = ours._replace(scenarios=ours.scenarios[::-1])
    with pytest.raises(ValueError, match="scenarios"):
        pair_draws(ours, apart)
