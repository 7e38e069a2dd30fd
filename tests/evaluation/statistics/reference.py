"""Reference implementations that statistics are tested against."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    Statistic,
    score_matrix,
)


def plain_statistic(function: Callable[[Floats], float]) -> Statistic:
    """Make a statistic of any function of a sample, such as ``numpy.median``.

    Every resample is written out, run by run, which takes the longest of all ways.
    """

    def statistic(scores: npt.ArrayLike, draws: CrossedDraws) -> Floats:
        matrix, resampled = score_matrix(scores, draws), []
        for seeds, scenarios in zip(
            draws.seeds.astype(int), draws.scenarios.astype(int), strict=True
        ):
            runs = matrix.repeat(seeds, axis=0).repeat(scenarios, axis=1)
            defined = runs[np.isfinite(runs)]
            resampled.append(function(defined) if len(defined) else np.nan)
        return np.array(resampled)

    return statistic
