"""Student's t for few training seeds: intervals and p-values from bootstrap resamples.

A percentile interval (Efron 1979) is too narrow for R seeds: the variance of the resamples is
(R - 1) / R of the unbiased one, and a normal quantile takes it as known. Hesterberg (2015, The
American Statistician 69) widens the levels of the percentiles; but no level reaches beyond the
extremes of the resamples, which two or three seeds need. Here the bounds q move instead:

    low, high = value + k (q - value),    k = s / s* . t_nu / z

with the variance s*^2 of the resamples, the quantiles t_nu of Student's and z of the normal
distribution, and (Satterthwaite 1946)

    s^2 = s*^2 + sum_p V_p / (R_p - 1),    nu = s^4 / sum_p (V_p R_p / (R_p - 1))^2 / (R_p - 1)

V_p is the part of s*^2 that comes from the seeds of policy p, ``sum_r cov(a_r, resampled)^2`` with
their counts a_r in the resamples (infinitesimal jackknife, Efron 2014). The rest comes from the
scenarios, which are many, so k is 1 if no policy has several seeds. ``docs/coverage.md`` compares
the coverage of intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.intervals import Estimate, percentile_interval


def student_interval(
    value: float, resampled: Floats, seeds: Sequence[Floats], *, confidence: float = 0.95
) -> Estimate:
    """Return a statistic with its percentile interval, widened for few seeds.

    Args:
        value: the statistic of the data.
        resampled: (B,) the statistic of each resample; NaN if undefined.
        seeds: of each policy that the statistic depends on, the counts (B, R) of its seeds.
        confidence: nominal coverage of the interval.
    """
    low, high = percentile_interval(value, resampled, confidence=confidence)[1:]
    if not math.isfinite(low):
        return Estimate(value, low, high)
    inflation, freedom = precision(resampled, seeds)
    tail = (1.0 + confidence) / 2.0
    factor = inflation * t_quantile(tail, freedom) / t_quantile(tail, math.inf)
    return Estimate(value, value + factor * (low - value), value + factor * (high - value))


def student_p_value(
    value: float, resampled: Floats, seeds: Sequence[Floats], *, null: float = 0.0,
    confidence: float = 0.95,
) -> float:  # fmt: skip
    """Return the two-sided p-value of a statistic, dual to ``student_interval``.

    It is a t-test. Its standard error is the distance from the value to the bound on the side of
    the null hypothesis, divided by the t quantile of that bound, so that ``p < 1 - confidence``
    where the interval excludes the null hypothesis. The smallest p of counted resamples is
    2 / (B + 1), which Holm's correction over a large family multiplies; here p has no such floor.

    Args:
        value: the statistic of the data.
        resampled: (B,) the statistic of each resample; NaN if undefined.
        seeds: counts of the seeds, as for ``student_interval``.
        null: the statistic under the null hypothesis of equal policies.
        confidence: of the interval.
    """
    _, low, high = student_interval(value, resampled, seeds, confidence=confidence)
    if not math.isfinite(low):
        return math.nan
    side = value - low if value > null else high - value
    if value == null or side <= 0.0:
        return float(value == null)
    freedom = precision(resampled, seeds)[1]
    t = abs(value - null) / side * t_quantile((1.0 + confidence) / 2.0, freedom)
    return 2.0 * t_tail(t, freedom)


def precision(resampled: Floats, seeds: Sequence[Floats]) -> tuple[float, float]:
    """Return the inflation ``s / s*`` of the standard error, and the degrees of freedom nu."""
    defined = np.isfinite(resampled)
    deviations = resampled[defined] - resampled[defined].mean()
    variance = float(np.mean(deviations**2))
    inflated, doubt = variance, 0.0
    for counts in seeds:
        freedom = counts.shape[1] - 1
        if freedom > 0:
            part = float(np.sum((deviations @ (counts[defined] - 1.0) / len(deviations)) ** 2))
            inflated += part / freedom
            doubt += (part * (1.0 + 1.0 / freedom)) ** 2 / freedom
    if doubt == 0.0:
        return 1.0, math.inf
    return math.sqrt(inflated / variance), inflated**2 / doubt


def t_quantile(level: float, freedom: float) -> float:
    """Return a quantile of Student's distribution, of the normal one at infinite freedom."""
    if math.isinf(freedom):
        return NormalDist().inv_cdf(level)
    from scipy.special import stdtrit  # of the extra "study"; only trained policies need it

    return float(stdtrit(freedom, level))


def t_tail(t: float, freedom: float) -> float:
    """Return the probability of more than t >= 0."""
    if math.isinf(freedom):
        return math.erfc(t / math.sqrt(2.0)) / 2.0
    from scipy.special import stdtr

    return float(stdtr(freedom, -t))
