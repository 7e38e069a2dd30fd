"""Multiple comparisons: bootstrap p-values, and Holm's correction over the declared family."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats


def bootstrap_p_value(resampled: Floats, *, null: float = 0.0) -> float:
    """Return the two-sided p-value of a paired comparison from its bootstrap distribution.

    ``p = min(1, 2 (1 + min(#{t_b <= null}, #{t_b >= null})) / (B + 1))``, the test dual to
    the percentile interval (Efron and Tibshirani 1993, chapter 15; the added 1: Davison and Hinkley
    1997). Flipping the signs of paired differences at random would be exact for two fixed policies,
    but it holds the training seeds fixed and needs differences that are symmetric about 0; those of
    rare events and intrusions are not. This test includes the variance of seeds and never
    contradicts the interval printed beside it. B must be large for a large family: p is at least 2
    / (B + 1).

    Args:
        resampled: (B,) the statistic of each resample, e.g. ``crossed_mean`` of ``differences``.
        null: the statistic under the null hypothesis of equal policies; 1/2 for ``improvements``.
    """
    defined = resampled[np.isfinite(resampled)]
    if not len(defined):
        return np.nan
    beyond = min(np.count_nonzero(defined <= null), np.count_nonzero(defined >= null))
    return min(1.0, 2 * (1 + beyond) / (len(defined) + 1))


def holm(p_values: npt.ArrayLike) -> Floats:
    """Return Holm-adjusted p-values, which control the family-wise error rate.

    ``p~_(i) = max_(j <= i) min(1, (m - j + 1) p_(j))``, the step-down procedure of Holm (1979):
    rejecting where ``p~ <= alpha`` rejects any true hypothesis with probability alpha at most,
    however the tests depend on each other.

    Args:
        p_values: (m,) of all comparisons that were declared; NaN marks a comparison that could not
            be made; it stays NaN and counts in m.
    """
    p = np.asarray(p_values, dtype=float)
    order = np.argsort(p)  # NaN last
    factors = np.arange(len(p), 0, -1)
    adjusted = np.empty_like(p)
    adjusted[order] = np.maximum.accumulate(np.minimum(1.0, factors * p[order]))
    return adjusted
