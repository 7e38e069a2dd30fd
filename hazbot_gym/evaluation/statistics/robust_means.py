"""Interquartile mean and conditional value at risk (CVaR), with bootstrap weights.

With Q the quantile function of the scores, all are ``1 / (high - low) int_low^high Q(u) du``. A run
at a boundary counts with the fraction inside.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    Statistic,
    run_weights,
    score_matrix,
)
from hazbot_gym.evaluation.statistics.intervals import ratio


def quantile_mean(low: float, high: float) -> Statistic:
    """Return the mean between two levels of the quantile function, ``0 <= low < high <= 1``."""
    if not 0.0 <= low < high <= 1.0:
        raise ValueError(f"levels: given {low} and {high}, allowed are 0 <= low < high <= 1")

    def statistic(scores: npt.ArrayLike, draws: CrossedDraws) -> Floats:
        every = score_matrix(scores, draws).ravel()
        order = np.argsort(every)
        runs = order[np.isfinite(every[order])]
        values = every[runs]
        parts = [_mean_between(low, high, values, weights) for weights in run_weights(runs, draws)]
        return np.concatenate(parts)

    return statistic


def interquartile_mean(scores: npt.ArrayLike, draws: CrossedDraws) -> Floats:
    """Return the interquartile mean (IQM, Agarwal et al. 2021) of each resample, (B,).

    Agarwal et al. drop whole runs, as ``scipy.stats.trim_mean`` does; both definitions agree if the
    number of runs is divisible by 4.
    """
    return quantile_mean(0.25, 0.75)(scores, draws)


def conditional_value_at_risk(alpha: float, *, worst: Literal["low", "high"]) -> Statistic:
    """Return the mean of the worst share of all runs, CVaR (Rockafellar and Uryasev 2000).

    Args:
        alpha: the share, in (0, 1].
        worst: the bad end, ``low`` for a clearance, ``high`` for an intrusion.
    """
    return quantile_mean(0.0, alpha) if worst == "low" else quantile_mean(1.0 - alpha, 1.0)


def _mean_between(low: float, high: float, values: Floats, weights: Floats) -> Floats:
    """Return the (b,) means of sorted values (M,) with weights (b, M), between two levels."""
    size = weights.sum(axis=1, keepdims=True)
    mass = np.clip(np.cumsum(weights, axis=1), low * size, high * size)
    inside = np.diff(mass, axis=1, prepend=low * size)
    return ratio(inside @ values, (high - low) * size[:, 0])
