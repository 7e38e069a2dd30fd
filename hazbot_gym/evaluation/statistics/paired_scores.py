"""Two policies in the same scenarios: the scores of every pair of their training seeds.

Seeds of two policies have nothing to do with each other, so each of ours (R) meets each of theirs
(S). A comparison is again a score matrix, (R S, N), on which every statistic of the crossed
bootstrap works: the mean of ``differences`` is the paired difference, the mean of ``improvements``
the probability of improvement.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import CrossedDraws


def pair_draws(ours: CrossedDraws, theirs: CrossedDraws) -> CrossedDraws:
    """Return how often each pair of seeds enters each resample, beside the scenarios of both.

    Raises:
        ValueError: the scenarios of the two were drawn apart, so nothing is paired.
    """
    shared = ours.scenarios is theirs.scenarios  # as a rule, and known without a look at them
    if not (shared or np.array_equal(ours.scenarios, theirs.scenarios)):
        raise ValueError("draws: given two draws of scenarios, allowed is one that both share")
    pairs = ours.seeds[:, :, None] * theirs.seeds[:, None, :]
    return CrossedDraws(pairs.reshape(len(pairs), -1), ours.scenarios)


def differences(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> Floats:
    """Return ``x_rn - y_sn``, (R S, N), of scores (R, N) and (S, N) over the same scenarios."""
    x, y = _seed_pairs(ours, theirs)
    with np.errstate(invalid="ignore"):  # infinite on both sides: not defined
        return (x - y).reshape(-1, x.shape[-1])


def improvements(ours: npt.ArrayLike, theirs: npt.ArrayLike) -> Floats:
    """Return where ours is more, ``1[x_rn > y_sn] + 1[x_rn = y_sn] / 2``, (R S, N).

    Its mean is the probability of improvement P(X > Y) within scenarios, the average over tasks of
    Agarwal et al. (2021) with every scenario a task. Where less is better, exchange the arguments.
    Infinite scores can be compared and count; NaN does not.
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
