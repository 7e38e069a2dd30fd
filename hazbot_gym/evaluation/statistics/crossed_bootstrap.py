"""Crossed (pigeonhole) bootstrap: confidence intervals over training seeds and scenarios.

The scores of a learned policy are a matrix (R, N): one row per training seed, one column per
scenario; all seeds meet the same scenarios. The run of seed r in scenario n enters a resample
``a_r b_n`` times, where a counts the draws of R seeds with replacement and b, independently, those
of the scenarios within each set: the pigeonhole bootstrap of Owen (2007, Annals of Applied
Statistics 1). Resampling the scenarios alone would describe these seeds only, and resampling runs
as if they were independent would give intervals that are too narrow. A deterministic policy has one
row. Few seeds widen an interval (``student``).

A score that is not finite counts as undefined and is left out, as in ``intervals``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.evaluation.statistics.intervals import (
    RESAMPLES,
    Estimate,
    ratio,
    scenario_draws,
    sums_of_defined,
)
from hazbot_gym.evaluation.statistics.student import student_interval

RESAMPLES_AT_A_TIME = 64  # weights of all runs, held at once; few enough to stay in the cache


class CrossedDraws(NamedTuple):
    """Counts of each training seed and each scenario in each of B resamples.

    Attributes:
        seeds: (B, R), of each pair of seeds if two policies are compared.
        scenarios: (B, N), shared by all policies that are compared.
        pair: (B, R) and (B, S), the counts of both policies' seeds if these are pairs.
    """

    seeds: Floats
    scenarios: Floats
    pair: tuple[Floats, ...] = ()

    @property
    def independent(self) -> tuple[Floats, ...]:
        """Counts of seeds that were drawn independently, an array per policy."""
        return self.pair or (self.seeds,)


Statistic = Callable[[npt.ArrayLike, CrossedDraws], Floats]  # of scores (R, N) or (N,): (B,)


def crossed_draws(
    strata: npt.ArrayLike,
    seeds: Iterable[int],
    rng: np.random.Generator,
    *,
    resamples: int = RESAMPLES,
) -> list[CrossedDraws]:
    """Draw the scenarios once for all policies, and for each policy its training seeds.

    A policy of one seed in sets of one scenario each leaves nothing to resample: its seed's counts
    are NaN, and with them every interval and p-value. A width of 0 would claim certainty from a
    single episode.

    Args:
        strata: (N,) label of each scenario's set; each set is resampled by itself, at its size.
        seeds: number of training seeds R of each policy; with R = 1 only the scenarios are
            resampled.
        rng: source of the draws. The scenarios are drawn first, as ``scenario_draws`` does.
        resamples: number of resamples B.
    """
    scenarios = scenario_draws(strata, rng, resamples=resamples)
    is_fixed = len(np.unique(np.asarray(strata))) == scenarios.shape[1]
    return [
        CrossedDraws(
            np.full((resamples, 1), np.nan)
            if is_fixed and number == 1
            else scenario_draws(np.zeros(number), rng, resamples=resamples),  # seeds are of one set
            scenarios,
        )
        for number in seeds
    ]


def each_once(draws: CrossedDraws) -> CrossedDraws:
    """Return the one resample that is the data itself: B = 1, every count 1."""
    seeds, scenarios = draws.seeds.shape[1], draws.scenarios.shape[1]
    return CrossedDraws(np.ones((1, seeds)), np.ones((1, scenarios)))


def score_matrix(scores: npt.ArrayLike, draws: CrossedDraws) -> Floats:
    """Return scores (R, N), or (N,) of one seed, as a matrix (R, N) that fits the draws.

    Raises:
        ValueError: the numbers of seeds or scenarios differ. Draws of one seed would broadcast to a
            matrix of many and ignore the variance of training.
    """
    matrix = np.atleast_2d(np.asarray(scores, dtype=float))
    drawn = (draws.seeds.shape[1], draws.scenarios.shape[1])
    if matrix.shape != drawn:
        raise ValueError(f"scores: given the shape {matrix.shape}, allowed is {drawn}, as drawn")
    return matrix


def crossed_mean(scores: npt.ArrayLike, draws: CrossedDraws) -> Floats:
    """Return the mean of each resample, ``sum_rn a_r b_n x_rn / sum_rn a_r b_n``, (B,)."""
    mean: Floats = crossed_means(score_matrix(scores, draws)[None], draws)[0]
    return mean


def crossed_means(scores: Floats, draws: CrossedDraws) -> Floats:
    """Return the crossed means of several metrics, (M, B), of scores (M, R, N).

    All in one matrix product, which reads the draws from memory only once.
    """
    metrics, seeds, scenarios = scores.shape
    flat = scores.reshape(metrics * seeds, scenarios)
    sums, sizes = (
        np.einsum("br,bmr->mb", draws.seeds, each.reshape(-1, metrics, seeds))
        for each in sums_of_defined(flat, draws.scenarios)
    )
    return ratio(sums, sizes)


def crossed_estimate(
    scores: npt.ArrayLike,
    draws: CrossedDraws,
    statistic: Statistic = crossed_mean,
    *,
    confidence: float = 0.95,
) -> Estimate:
    """Estimate a statistic of the scores with its crossed interval, widened for few seeds.

    Args:
        scores: (R, N), or (N,) of one seed.
        draws: from ``crossed_draws``, or ``pair_draws`` where the scores compare two policies.
        statistic: the statistic; default the mean.
        confidence: nominal coverage of the interval.
    """
    value = float(statistic(scores, each_once(draws))[0])
    resampled = statistic(scores, draws)
    return student_interval(value, resampled, draws.independent, confidence=confidence)


def crossed_estimates(
    scores: Floats, draws: CrossedDraws, *, confidence: float = 0.95
) -> list[Estimate]:
    """Estimate the means of several metrics, given as scores (M, R, N), as ``crossed_estimate``."""
    values, resampled = crossed_means(scores, each_once(draws)), crossed_means(scores, draws)
    return [
        student_interval(float(value), means, draws.independent, confidence=confidence)
        for value, means in zip(values[:, 0], resampled, strict=True)
    ]


def run_weights(runs: Ints, draws: CrossedDraws) -> Iterator[Floats]:
    """Yield the weights ``a_r b_n`` of runs, (b, M), in batches of resamples.

    Args:
        runs: (M,) flat indices into the score matrix, in the order of the returned weights.
        draws: B resamples, in batches of ``RESAMPLES_AT_A_TIME``.
    """
    rows, columns = np.divmod(runs, draws.scenarios.shape[1])
    for start in range(0, len(draws.seeds), RESAMPLES_AT_A_TIME):
        some = slice(start, start + RESAMPLES_AT_A_TIME)
        seeds, scenarios = draws.seeds[some], draws.scenarios[some]
        yield np.take(seeds, rows, axis=1) * np.take(scenarios, columns, axis=1)
