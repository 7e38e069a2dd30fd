"""Whole distributions instead of one number: which share of runs lies beyond each threshold.

The band is pointwise: each threshold's interval covers as often as it says, not all at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.study.crossed_bootstrap import CrossedDraws, crossed_estimate


class Curve(NamedTuple):
    """A share of runs for each threshold, all (T,)."""

    thresholds: Floats
    share: Floats
    low: Floats
    high: Floats


def performance_profile(
    scores: npt.ArrayLike,
    thresholds: npt.ArrayLike,
    draws: CrossedDraws,
    *,
    confidence: float = 0.95,
) -> Curve:
    """Estimate which share of runs scores more than each threshold.

    Dolan and More (2002); over all runs and seeds: the score distribution of Agarwal et al. (2021).

    Args:
        scores: (R, N), or (N,) of one seed; NaN is left out, infinite scores count.
        thresholds: (T,) values tau.
        draws: from ``crossed_draws``.
        confidence: nominal coverage of the band at each threshold.
    """
    values = np.atleast_2d(np.asarray(scores, dtype=float))
    taus = np.asarray(thresholds, dtype=float)
    estimates = [
        crossed_estimate(
            np.where(np.isnan(values), np.nan, values > tau), draws, confidence=confidence
        )
        for tau in taus
    ]
    return Curve(taus, *(np.array(column) for column in zip(*estimates, strict=True)))


def empirical_cdf(
    scores: npt.ArrayLike,
    thresholds: npt.ArrayLike,
    draws: CrossedDraws,
    *,
    confidence: float = 0.95,
) -> Curve:
    """Estimate which share of runs scores at most each threshold; see ``performance_profile``."""
    profile = performance_profile(scores, thresholds, draws, confidence=confidence)
    return Curve(profile.thresholds, 1 - profile.share, 1 - profile.high, 1 - profile.low)
