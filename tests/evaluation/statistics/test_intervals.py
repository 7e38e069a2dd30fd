from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.evaluation.statistics.intervals import (
    bootstrap_mean,
    scenario_draws,
    wilson,
)

REFERENCE = json.loads(
    (Path(__file__).parents[2] / "reference" / "wilson_intervals.json").read_text(encoding="utf-8")
)


@pytest.mark.parametrize("case", REFERENCE["cases"])
def test_wilson_agrees_with_published_intervals(case: dict[str, float]) -> None:
    rate, low, high = wilson(case["successes"], case["trials"])
    assert rate == case["successes"] / case["trials"]
    assert low == pytest.approx(case["low"], abs=REFERENCE["tolerance"])
    assert high == pytest.approx(case["high"], abs=REFERENCE["tolerance"])


def test_wilson_is_symmetric_between_success_and_failure() -> None:
    _, low, high = wilson(7, 40)
    _, other_low, other_high = wilson(33, 40)
    assert (low, high) == pytest.approx((1 - other_high, 1 - other_low))


def test_wilson_stays_within_0_and_1_and_holds_its_rate() -> None:
    for successes in (0, 50):
        rate, low, high = wilson(successes, 50)
        assert 0.0 <= low <= rate <= high <= 1.0


def test_no_trials_give_no_estimate() -> None:
    assert np.isnan(wilson(0, 0)).all()


def test_wilson_covers_the_true_rate_as_often_as_it_says() -> None:
    rng = np.random.default_rng(1)
    estimates = [wilson(successes, 60) for successes in rng.binomial(60, 0.1, size=2000)]
    covered = np.mean([low <= 0.1 <= high for _, low, high in estimates])
    assert covered == pytest.approx(0.95, abs=0.025)


def test_bootstrap_covers_the_true_mean_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(2)
    hits = []
    for _ in range(400):
        values = rng.exponential(1.0, size=60)
        _, low, high = bootstrap_mean(values, scenario_draws(np.zeros(60), rng, resamples=400))
        hits.append(low <= 1.0 <= high)
    # The percentile bootstrap is known to fall a little short for skewed data of this size.
    assert 0.90 <= np.mean(hits) <= 0.97


def test_bootstrap_interval_shrinks_to_the_textbook_width() -> None:
    rng = np.random.default_rng(3)
    values = rng.normal(5.0, 2.0, size=1000)
    mean, low, high = bootstrap_mean(values, scenario_draws(np.zeros(1000), rng))
    assert mean == pytest.approx(values.mean())
    assert (high - low) / 2 == pytest.approx(1.96 * values.std() / np.sqrt(1000), rel=0.1)


def test_every_resample_keeps_the_size_of_every_set() -> None:
    strata = ["a"] * 3 + ["b"] * 5 + ["a"] * 2
    draws = scenario_draws(strata, np.random.default_rng(0), resamples=50)
    in_a = np.array([label == "a" for label in strata])
    assert (draws[:, in_a].sum(axis=1) == 5).all()
    assert (draws[:, ~in_a].sum(axis=1) == 5).all()


def test_differences_between_sets_do_not_widen_the_interval_of_all_sets() -> None:
    values = np.repeat([0.0, 100.0], 20)
    rng = np.random.default_rng(0)
    _, low, high = bootstrap_mean(values, scenario_draws(values, rng))
    assert (low, high) == (50.0, 50.0)


def test_undefined_values_are_left_out() -> None:
    values = [1.0, np.nan, 3.0, np.inf]
    estimate = bootstrap_mean(values, scenario_draws([0] * 4, np.random.default_rng(0)))
    assert estimate.mean == 2.0
    assert 1.0 <= estimate.low <= estimate.high <= 3.0
    nowhere = bootstrap_mean([np.nan] * 4, scenario_draws([0] * 4, np.random.default_rng(0)))
    assert np.isnan(nowhere).all()


def test_pairing_cancels_what_the_scenarios_have_in_common() -> None:
    rng = np.random.default_rng(4)
    difficulty = rng.normal(0.0, 10.0, size=80)
    ours, theirs = difficulty + 1.0, difficulty + rng.normal(0.0, 0.1, size=80)
    draws = scenario_draws(np.zeros(80), rng)
    difference = bootstrap_mean(ours - theirs, draws)
    assert difference.mean == pytest.approx(1.0, abs=0.05)
    assert difference.high - difference.low < 0.1
    assert bootstrap_mean(ours - ours, draws) == (0.0, 0.0, 0.0)


def test_the_same_generator_gives_the_same_interval() -> None:
    values = np.arange(30.0)
    one, other = (
        bootstrap_mean(values, scenario_draws(np.zeros(30), np.random.default_rng(7)))
        for _ in range(2)
    )
    assert one == other
