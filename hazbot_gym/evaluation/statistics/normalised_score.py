"""Normalised score: 0 is the constant speed, 1 the optimum, for every set of scenarios."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.intervals import ratio


def normalised_score(
    score: npt.ArrayLike, constant: npt.ArrayLike, optimum: npt.ArrayLike
) -> Floats:
    """Return ``(J - J_const) / (J_opt - J_const)``; NaN if the optimum equals the constant speed.

    A scenario with almost no headroom gives huge values; report medians and interquartile means of
    such scores, or normalise means.

    Args:
        score: J, of any shape.
        constant: J_const of the best constant speed, chosen on other scenarios; broadcasts with J.
        optimum: J_opt, the largest achievable return; broadcasts with J.
    """
    j, low, top = np.broadcast_arrays(*(np.asarray(x, float) for x in (score, constant, optimum)))
    return ratio(j - low, top - low)
