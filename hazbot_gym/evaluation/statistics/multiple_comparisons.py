"""Multiple comparisons: Holm's correction over the declared family."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats


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
