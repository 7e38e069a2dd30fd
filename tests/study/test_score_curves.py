from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.study.crossed_bootstrap import CrossedDraws, crossed_draws
from hazbot_gym.study.score_curves import empirical_cdf, performance_profile


def draw(seeds: int, scenarios: int) -> CrossedDraws:
    rng = np.random.default_rng(0)
    (draws,) = crossed_draws(np.zeros(scenarios), [seeds], rng, resamples=300)
    return draws


SCORES = [[0.0, 1.0, 2.0, np.inf], [1.0, np.nan, 3.0, np.inf]]  # seven runs


def test_shares_by_hand() -> None:
    profile = performance_profile(SCORES, [-1.0, 1.0, 2.5, 1e9], draw(2, 4))
    assert profile.thresholds.tolist() == [-1.0, 1.0, 2.5, 1e9]
    assert profile.share == pytest.approx([1.0, 4 / 7, 3 / 7, 2 / 7])
    cdf = empirical_cdf(SCORES, [-1.0, 1.0, 2.5, 1e9], draw(2, 4))
    assert cdf.share == pytest.approx([0.0, 3 / 7, 4 / 7, 5 / 7])


def test_band_has_the_textbook_width() -> None:
    scores = np.random.default_rng(1).normal(size=400)
    cdf = empirical_cdf(scores, [-1.0, 0.0, 1.0], draw(1, 400))
    half = 1.96 * np.sqrt(cdf.share * (1 - cdf.share) / 400)
    assert (cdf.high - cdf.low) / 2 == pytest.approx(half, rel=0.2)


@given(st.lists(st.integers(-5, 5), min_size=3, max_size=12), st.integers(2, 6))
def test_curves_are_monotonous_within_their_band_and_complements(
    runs: list[int], steps: int
) -> None:
    thresholds, draws = np.linspace(-6.0, 6.0, steps), draw(1, len(runs))
    profile = performance_profile(runs, thresholds, draws)
    cdf = empirical_cdf(runs, thresholds, draws)
    for ends in (profile.share, profile.low, profile.high):
        assert (np.diff(ends) <= 0.0).all()
    assert cdf.share + profile.share == pytest.approx(1.0)
    assert (cdf.low <= cdf.high).all()
    assert cdf.low == pytest.approx(1 - profile.high)
    assert (cdf.share[0], cdf.share[-1]) == (0.0, 1.0)
