"""Which of two policies scores more, whatever the scenarios: P(X > Y) between unpaired runs.

``P(X > Y) + P(X = Y) / 2 = U / (n_x n_y)`` with the statistic U of Mann and Whitney (1947), the
probability of improvement within one task of Agarwal et al. (2021); a task is a set of scenarios.
Here a run in an easy scenario also meets one in a hard scenario. ``paired_scores.improvements``
compares within scenarios only and is the sharper of the two.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.study.crossed_bootstrap import CrossedDraws, each_once, run_weights, score_matrix
from hazbot_gym.study.statistics import Estimate, percentile_interval, ratio


def unpaired_improvement(
    ours: npt.ArrayLike,
    theirs: npt.ArrayLike,
    our_draws: CrossedDraws,
    their_draws: CrossedDraws,
    *,
    confidence: float = 0.95,
) -> Estimate:
    """Estimate the probability that a run of ours scores more than a run of theirs.

    Args:
        ours: (R, N) scores, or (N,) of one seed; NaN is left out, infinite scores count.
        theirs: (S, N) or (N,).
        our_draws: from ``crossed_draws``.
        their_draws: of as many resamples.
        confidence: nominal coverage of the interval.
    """
    x = score_matrix(ours, our_draws).ravel()
    y = score_matrix(theirs, their_draws).ravel()
    value = float(_wins(x, y, each_once(our_draws), each_once(their_draws))[0])
    resampled = _wins(x, y, our_draws, their_draws)
    return percentile_interval(value, resampled, confidence=confidence)


def _wins(x: Floats, y: Floats, x_draws: CrossedDraws, y_draws: CrossedDraws) -> Floats:
    """Return each resample's ``U / (n_x n_y)``, (B,)."""
    x_runs, y_runs = _in_order(x), _in_order(y)
    below = np.searchsorted(y[y_runs], x[x_runs], side="left")
    not_above = np.searchsorted(y[y_runs], x[x_runs], side="right")
    parts = []
    for wx, wy in zip(run_weights(x_runs, x_draws), run_weights(y_runs, y_draws), strict=True):
        beaten = np.cumsum(np.pad(wy, ((0, 0), (1, 0))), axis=1)  # weight of the first k of theirs
        u = (wx * (np.take(beaten, below, axis=1) + np.take(beaten, not_above, axis=1))).sum(axis=1)
        parts.append(ratio(u / 2, wx.sum(axis=1) * beaten[:, -1]))
    return np.concatenate(parts)


def _in_order(values: Floats) -> Ints:
    """Return the indices that sort what is not NaN."""
    return np.argsort(values)[: np.count_nonzero(~np.isnan(values))]
