"""Confidence intervals for rates, means and differences of paired policies.

All resampling is over scenarios (the only source of variance of a deterministic policy; for several
training seeds see ``crossed_bootstrap``) and takes an explicit generator. One draw of scenarios
serves every metric and every policy, so that pairs are kept.
"""

from __future__ import annotations

from statistics import NormalDist
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats

RESAMPLES = 2000


class Estimate(NamedTuple):
    """A mean or other statistic, and its interval.

    All are NaN without any value to average; only the bounds are NaN if nothing can be resampled.
    """

    mean: float
    low: float
    high: float


def within(estimate: Estimate, least: float, most: float = np.inf) -> Estimate:
    """Return an estimate with its interval cut to the possible values."""
    low, high = (float(np.clip(bound, least, most)) for bound in estimate[1:])
    return Estimate(estimate.mean, low, high)


def wilson(successes: float, trials: int, *, confidence: float = 0.95) -> Estimate:
    """Estimate a rate with the Wilson score interval (1927), valid also at 0 and at 100 %.

    ``(p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)``
    """
    if trials == 0:
        return Estimate(np.nan, np.nan, np.nan)
    z, n, p = NormalDist().inv_cdf(0.5 + confidence / 2), trials, successes / trials
    centre = p + z**2 / (2 * n)
    half = z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    scale = 1 + z**2 / n
    low, high = (centre - half) / scale, (centre + half) / scale
    # Rounding must not leave the rate itself outside its interval at the two ends.
    return Estimate(p, float(min(max(low, 0.0), p)), float(max(min(high, 1.0), p)))


def scenario_draws(
    strata: npt.ArrayLike, rng: np.random.Generator, *, resamples: int = RESAMPLES
) -> Floats:
    """Draw the count of each scenario in each resample, (resamples, n).

    Args:
        strata: (n,) label of each scenario's set; each set is resampled separately, at its size.
        rng: random generator.
        resamples: number of resamples B.
    """
    labels = np.asarray(strata)
    draws = np.zeros((resamples, len(labels)))
    for label in dict.fromkeys(labels.tolist()):
        (members,) = np.nonzero(labels == label)
        fair = np.full(len(members), 1 / len(members))
        draws[:, members] = rng.multinomial(len(members), fair, size=resamples)
    return draws


def bootstrap_mean(values: npt.ArrayLike, draws: Floats, *, confidence: float = 0.95) -> Estimate:
    """Estimate a mean with the percentile bootstrap of Efron (1979).

    Args:
        values: (n,) one number per scenario; NaN if undefined.
        draws: (B, n) counts from ``scenario_draws``.
        confidence: nominal coverage of the interval.
    """
    value = np.asarray(values, dtype=float)
    known = value[np.isfinite(value)]
    mean = float(known.mean()) if len(known) else np.nan
    return percentile_interval(mean, ratio(*sums_of_defined(value, draws)), confidence=confidence)


def sums_of_defined(values: Floats, draws: Floats) -> tuple[Floats, Floats]:
    """Return the sum and count of finite values in each resample.

    Args:
        values: (n,) or (R, n) numbers, a column per scenario.
        draws: (B, n) counts from ``scenario_draws``.

    Returns:
        Sums and numbers of summands, both (B,) or (B, R).
    """
    known = np.isfinite(values)
    if known.all():  # as most metrics are: half the work
        sums = draws @ values.T
        sizes = draws.sum(axis=1).reshape(-1, *[1] * (values.ndim - 1))
        return sums, np.broadcast_to(sizes, sums.shape)
    return draws @ np.where(known, values, 0.0).T, draws @ known.T.astype(float)


def ratio(numerator: Floats, denominator: Floats) -> Floats:
    """Divide two arrays of one shape; NaN where the denominator is 0."""
    quotient = np.full(np.shape(numerator), np.nan)
    np.divide(numerator, denominator, out=quotient, where=np.asarray(denominator) != 0)
    return quotient


def percentile_interval(value: float, resampled: Floats, *, confidence: float = 0.95) -> Estimate:
    """Return a statistic with its percentile interval (Efron 1979).

    Args:
        value: the statistic of the data.
        resampled: (B,) the statistic of each resample; NaN without any value to average.
        confidence: nominal coverage of the interval.
    """
    defined = resampled[np.isfinite(resampled)]
    if not np.isfinite(value):
        return Estimate(np.nan, np.nan, np.nan)
    if not len(defined):
        return Estimate(float(value), np.nan, np.nan)
    low, high = np.quantile(defined, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Estimate(float(value), float(low), float(high))
