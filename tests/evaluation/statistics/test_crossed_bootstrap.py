from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    RESAMPLES_AT_A_TIME,
    CrossedDraws,
    Statistic,
    crossed_draws,
    crossed_estimate,
    crossed_estimates,
    crossed_mean,
    each_once,
    run_weights,
)
from hazbot_gym.evaluation.statistics.intervals import bootstrap_mean, scenario_draws
from hazbot_gym.evaluation.statistics.robust_means import (
    conditional_value_at_risk,
    interquartile_mean,
)
from tests.evaluation.statistics.reference import plain_statistic

STATISTICS: tuple[Statistic, ...] = (
    crossed_mean,
    interquartile_mean,
    conditional_value_at_risk(0.1, worst="low"),
)


def draw(seeds: int, scenarios: int, *, resamples: int = 200) -> CrossedDraws:
    rng = np.random.default_rng(0)
    (draws,) = crossed_draws(np.zeros(scenarios), [seeds], rng, resamples=resamples)
    return draws


def additive_scores(seeds: int, scenarios: int, rng: np.random.Generator) -> Floats:
    """Scores symmetric about 0: effects of the seed, of the scenario, and of the run."""
    effects = rng.normal(0.0, 0.1, (seeds, 1)) + rng.normal(0.0, 0.5, scenarios)
    return effects + rng.normal(0.0, 0.3, (seeds, scenarios))


# --- how often the interval covers ---------------------------------------------------------------


def coverage(draws: CrossedDraws, statistic: Statistic = crossed_mean) -> float:
    """Return the share of intervals that hold the truth, 0.

    Draws know nothing of the scores, so one large set of them serves all studies.
    """
    rng = np.random.default_rng(1)
    size = draws.seeds.shape[1], draws.scenarios.shape[1]
    estimates = [
        crossed_estimate(additive_scores(*size, rng), draws, statistic) for _ in range(300)
    ]
    return float(np.mean([low <= 0.0 <= high for _, low, high in estimates]))


@pytest.mark.parametrize(
    ("seeds", "scenarios", "statistic"),
    [(5, 100, crossed_mean), (10, 200, crossed_mean), (5, 100, interquartile_mean)],
)
def test_crossed_interval_covers_about_as_often_as_it_says(
    seeds: int, scenarios: int, statistic: Statistic
) -> None:
    assert 0.88 <= coverage(draw(seeds, scenarios, resamples=600), statistic) <= 0.99


def test_scenarios_alone_cover_far_too_seldom_where_seeds_vary() -> None:
    crossed = draw(5, 500, resamples=1000)
    scenarios_only = crossed._replace(seeds=np.ones_like(crossed.seeds))
    assert coverage(scenarios_only) < 0.7
    assert coverage(crossed) > 0.85


# --- what is drawn -------------------------------------------------------------------------------


def test_every_resample_has_as_many_seeds_and_scenarios_of_every_set() -> None:
    strata = np.array(["a"] * 3 + ["b"] * 5)
    draws, other = crossed_draws(strata, [4, 2], np.random.default_rng(0), resamples=50)
    assert other.scenarios is draws.scenarios
    np.testing.assert_array_equal(
        draws.scenarios, scenario_draws(strata, np.random.default_rng(0), resamples=50)
    )
    assert (draws.seeds.shape, other.seeds.shape) == ((50, 4), (50, 2))
    assert (draws.seeds.sum(axis=1) == 4).all()
    assert (draws.scenarios[:, strata == "a"].sum(axis=1) == 3).all()
    assert (draws.scenarios[:, strata == "b"].sum(axis=1) == 5).all()


def test_a_single_seed_is_in_every_resample_once() -> None:
    assert (draw(1, 7).seeds == 1.0).all()


def test_weights_are_the_products_of_counts_in_the_order_asked_for() -> None:
    draws = draw(3, 5, resamples=RESAMPLES_AT_A_TIME + 1)
    runs = np.array([14, 0, 7])  # (2, 4), (0, 0), (1, 2)
    first, last = run_weights(runs, draws)
    assert last.shape == (1, 3)
    np.testing.assert_array_equal(
        np.concatenate([first, last]),
        np.stack(
            [draws.seeds[:, r] * draws.scenarios[:, n] for r, n in ((2, 4), (0, 0), (1, 2))]
        ).transpose(),
    )


# --- what is estimated ---------------------------------------------------------------------------


def test_mean_of_a_resample_by_hand() -> None:
    draws = CrossedDraws(np.array([[2.0, 0.0], [1.0, 1.0]]), np.array([[1.0, 2.0], [0.0, 3.0]]))
    scores = np.array([[1.0, 4.0], [10.0, 20.0]])
    # Twice the first row with (1 + 4 + 4) / 3; then both rows, the second scenario only.
    assert crossed_mean(scores, draws) == pytest.approx([3.0, 12.0])


@pytest.mark.parametrize("undefined", [0, 9])
def test_mean_is_that_of_resamples_written_out(undefined: int) -> None:
    scores = np.random.default_rng(3).normal(size=(4, 9))
    scores.flat[:undefined] = np.nan  # all of one seed, if any
    draws = draw(4, 9)
    written_out = plain_statistic(lambda runs: float(np.mean(runs)))(scores, draws)
    np.testing.assert_allclose(crossed_mean(scores, draws), written_out)


@pytest.mark.parametrize("undefined", [0, 6])
def test_one_seed_is_the_bootstrap_over_scenarios(undefined: int) -> None:
    scores = np.random.default_rng(4).normal(size=40)
    scores[:undefined] = np.nan
    draws = draw(1, 40)
    known = bootstrap_mean(scores, draws.scenarios)
    assert crossed_estimate(scores, draws) == pytest.approx(known, rel=1e-12)


def test_metrics_estimated_together_are_those_estimated_one_by_one() -> None:
    scores = np.random.default_rng(8).normal(size=(5, 3, 12))
    scores[1, 0, :4] = np.nan
    scores[2] = np.nan
    draws = draw(3, 12)
    together = crossed_estimates(scores, draws, confidence=0.9)
    alone = [crossed_estimate(metric, draws, confidence=0.9) for metric in scores]
    np.testing.assert_allclose(together, alone, rtol=1e-12)


def test_any_function_of_a_sample_can_be_estimated() -> None:
    scores = np.random.default_rng(5).normal(size=(3, 15))
    median = plain_statistic(lambda runs: float(np.median(runs)))
    value, low, high = crossed_estimate(scores, draw(3, 15), median)
    assert value == np.median(scores)
    assert low < value < high


def test_variance_of_seeds_alone_makes_an_interval() -> None:
    scores = np.repeat([[1.0], [3.0]], 30, axis=1)
    value, low, high = crossed_estimate(scores, draw(2, 30))
    assert value == 2.0
    half = stats.t.ppf(0.975, 1) / stats.norm.ppf(0.975) * math.sqrt(2.0)
    assert [low, high] == pytest.approx([2.0 - half, 2.0 + half], rel=0.15)
    assert crossed_estimate(scores[0], draw(1, 30)) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_nothing_defined_gives_no_estimate(statistic: Statistic) -> None:
    estimate = crossed_estimate(np.full((2, 5), np.nan), draw(2, 5), statistic)
    assert np.isnan(estimate).all()


@pytest.mark.parametrize("statistic", STATISTICS)
def test_what_is_not_finite_does_not_count(statistic: Statistic) -> None:
    scores = np.array([[1.0, np.nan, 3.0], [np.inf, 2.0, -np.inf]])
    value, low, high = crossed_estimate(scores, draw(2, 3), statistic)
    assert value == pytest.approx(
        float(statistic(np.array([[1.0, 2.0, 3.0]]), each_once(draw(1, 3)))[0])
    )
    assert -math.inf < low <= value <= high < math.inf


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("shape", [(10, 5), (2, 4), (5,)])
def test_scores_of_other_seeds_or_scenarios_than_drawn_are_refused(
    statistic: Statistic, shape: tuple[int, ...]
) -> None:
    draws = draw(1 if len(shape) == 2 else 2, 5)
    with pytest.raises(ValueError, match="scores"):
        crossed_estimate(np.zeros(shape), draws, statistic)


def test_confidence_widens_the_interval() -> None:
    scores, draws = np.random.default_rng(6).normal(size=(5, 50)), draw(5, 50)
    narrow, wide = (crossed_estimate(scores, draws, confidence=level) for level in (0.5, 0.99))
    assert wide.low < narrow.low < narrow.high < wide.high


# --- properties ----------------------------------------------------------------------------------

MATRICES = st.lists(
    st.lists(st.integers(-50, 50), min_size=6, max_size=6), min_size=3, max_size=3
).map(lambda rows: np.array(rows, dtype=float))


@pytest.mark.parametrize("statistic", STATISTICS)
@given(scores=MATRICES, factor=st.integers(1, 9), shift=st.integers(-9, 9))
def test_scale_and_origin_of_the_scores_carry_over(
    statistic: Statistic, scores: Floats, factor: int, shift: int
) -> None:
    draws = draw(3, 6)
    one = np.array(crossed_estimate(scores, draws, statistic))
    other = np.array(crossed_estimate(factor * scores + shift, draws, statistic))
    np.testing.assert_allclose(other, factor * one + shift, atol=1e-9)


@pytest.mark.parametrize("statistic", STATISTICS)
@given(scores=MATRICES, rows=st.permutations(range(3)), columns=st.permutations(range(6)))
def test_order_of_seeds_and_scenarios_does_not_matter(
    statistic: Statistic, scores: Floats, rows: list[int], columns: list[int]
) -> None:
    draws = draw(3, 6)
    shuffled = CrossedDraws(draws.seeds[:, rows], draws.scenarios[:, columns])
    one = crossed_estimate(scores, draws, statistic)
    other = crossed_estimate(scores[rows][:, columns], shuffled, statistic)
    np.testing.assert_allclose(other, one, atol=1e-9)


@pytest.mark.parametrize("statistic", STATISTICS)
@given(scores=MATRICES, gains=MATRICES)
def test_higher_scores_give_higher_resamples(
    statistic: Statistic, scores: Floats, gains: Floats
) -> None:
    draws = draw(3, 6)
    one, other = statistic(scores, draws), statistic(scores + np.abs(gains), draws)
    assert (other >= one - 1e-9).all()
    assert scores.min() - 1e-9 <= one.min() <= one.max() <= scores.max() + 1e-9
