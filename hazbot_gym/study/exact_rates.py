"""Rates of rare events, such as contacts: exact intervals, and what no event at all proves.

They speak of independent episodes of one policy. Episodes of several training seeds are not
independent; their rate is a mean for ``crossed_bootstrap``.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.errors import MissingExtra
from hazbot_gym.study.statistics import Estimate

try:
    from scipy.special import betaincinv
except ImportError as error:
    raise MissingExtra("scipy", "study") from error


def clopper_pearson(successes: int, trials: int, *, confidence: float = 0.95) -> Estimate:
    """Estimate a rate with the exact interval of Clopper and Pearson (1934).

    With alpha = 1 - confidence it runs from the quantile alpha/2 of Beta(k, n - k + 1) to the
    quantile 1 - alpha/2 of Beta(k + 1, n - k). It covers at least as often as it says, and is wider
    than ``wilson``, which does so on average.
    """
    if trials == 0:
        return Estimate(np.nan, np.nan, np.nan)
    k, n, one_sided = successes, trials, (1 + confidence) / 2
    return Estimate(k / n, lower_bound(k, n, one_sided), upper_bound(k, n, one_sided))


def lower_bound(successes: int, trials: int, confidence: float = 0.95) -> float:
    """Return the exact one-sided lower bound of a rate: that of failures, mirrored."""
    return 1.0 - upper_bound(trials - successes, trials, confidence)


def upper_bound(successes: int, trials: int, confidence: float = 0.95) -> float:
    """Return the exact one-sided upper bound of a rate.

    Without any event in n trials this is ``1 - (1 - confidence)^(1/n)``, about ``3 / n`` at 95 %
    (Hanley and Lippman-Hand 1983).
    """
    if successes == trials:
        return 1.0
    return float(betaincinv(successes + 1, trials - successes, confidence))
