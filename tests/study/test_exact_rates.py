from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from hazbot_gym.study.exact_rates import clopper_pearson, lower_bound, upper_bound
from hazbot_gym.study.statistics import wilson

COUNTS = st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@given(COUNTS, st.sampled_from([0.8, 0.95, 0.99]))
def test_clopper_pearson_is_the_inversion_of_the_binomial_test(
    counts: tuple[int, int], confidence: float
) -> None:
    rate, low, high = clopper_pearson(*counts, confidence=confidence)
    known = binomtest(*counts).proportion_ci(confidence, method="exact")
    assert (low, high) == pytest.approx((known.low, known.high), abs=1e-9)
    assert low <= rate == counts[0] / counts[1] <= high


@given(COUNTS)
def test_one_sided_bounds_are_those_of_the_binomial_test(counts: tuple[int, int]) -> None:
    at_most = binomtest(*counts, alternative="less").proportion_ci(method="exact")
    at_least = binomtest(*counts, alternative="greater").proportion_ci(method="exact")
    assert upper_bound(*counts) == pytest.approx(at_most.high, abs=1e-9)
    assert lower_bound(*counts) == pytest.approx(at_least.low, abs=1e-9)


@pytest.mark.parametrize(("trials", "proves_less_than"), [(1000, 0.0030), (4000, 0.00075)])
def test_no_event_at_all_proves_a_rate_below_3_in_n(trials: int, proves_less_than: float) -> None:
    bound = upper_bound(0, trials)
    assert bound == pytest.approx(1 - 0.05 ** (1 / trials))
    assert 0.99 * proves_less_than < bound < proves_less_than


@pytest.mark.parametrize("rate", [0.001, 0.03, 0.2, 0.5])
def test_the_exact_interval_never_covers_less_than_it_says(rate: float) -> None:
    intervals = np.array([clopper_pearson(k, 60)[1:] for k in range(61)])
    covers = (intervals[:, 0] <= rate) & (rate <= intervals[:, 1])
    assert binom.pmf(np.arange(61), 60, rate)[covers].sum() >= 0.95


def test_the_exact_interval_is_wider_than_wilsons() -> None:
    exact, usual = clopper_pearson(50, 1000), wilson(50, 1000)
    assert exact.high - exact.low > usual.high - usual.low


def test_no_trials_prove_nothing() -> None:
    assert np.isnan(clopper_pearson(0, 0)).all()
    assert (lower_bound(0, 0), upper_bound(0, 0)) == (0.0, 1.0)
