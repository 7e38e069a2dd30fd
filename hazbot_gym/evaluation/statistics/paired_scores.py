"""Paired scores of two policies in the same scenarios, for every pair of training seeds.

Seeds of two policies are independent, so each of ours (R) is paired with each of theirs (S). The
result is again a score matrix, (R S, N), for every statistic of the crossed bootstrap: the mean of
``differences`` is the paired difference, the mean of ``improvements`` the probability of
improvement.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import CrossedDraws


def pair_draws(ours: CrossedDraws, theirs: CrossedDraws) -> CrossedDraws:
    """Return the count of each pair of seeds in each resample, with the shared scenario counts.

    Raises:
        ValueError: the two have different scenario draws, so that nothing is paired.
    """
    shared = ours.scenarios is theirs.scenarios  # the usual case, known without comparing values
    if not (shared or np.array_equal(ours.scenarios, theirs.scenarios)):
        raise ValueError("draws: given two draws of scenarios, allowed is one that both share")
    pairs = ours.seeds[:, :, None] * theirs.seeds[:, None, :]
    flat = pairs.reshape(len(pairs), -1)
    return CrossedDraws(flat, ours.scenarios, (ours.seeds, theirs.seeds))


def differences(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> Floats:
    """Return ``x_rn - y_sn``, (R S, N), of scores (R, N) and (S, N) over the same scenarios."""
    x, y = _seed_pairs(ours, theirs)
    with np.errstate(invalid="ignore"):  # infinite on both sides: not defined
        return (x - y).reshape(-1, x.shape[-1])


def improvements(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> Floats:
    """Return the indicator of ours being larger, ``1[x_rn > y_sn] + 1[x_rn = y_sn] / 2``, (R S, N).

    Its mean is the probability of improvement P(X > Y) within scenarios, the average over tasks of
    Agarwal et al. (2021) with every scenario a task. If less is better, exchange the arguments.
    Infinite scores count; NaN does not.
    """
    x, y = _seed_pairs(ours, theirs)
    wins = np.where(np.isnan(x) | np.isnan(y), np.nan, (x > y) + 0.5 * (x == y))
    return wins.reshape(-1, wins.shape[-1])


def _seed_pairs(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Return both scores such that they broadcast to (R, S, N)."""
    x = np.atleast_2d(np.asarray(ours, dtype=float))
    y = np.atleast_2d(np.asarray(theirs, dtype=float))
    if x.shape[1] != y.shape[1]:
        raise ValueError(
            f"scores: given {x.shape[1]} and {y.shape[1]} scenarios, allowed are the same"
        )
    return x[:, None, :], y[None, :, :]
