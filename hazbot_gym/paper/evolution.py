"""Differential evolution (Storn and Price 1997) with a fixed budget."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hazbot_gym.errors import MissingExtra

try:
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc
except ImportError as error:
    raise MissingExtra("scipy", "study") from error

from hazbot_gym.core.state import Floats

MEMBERS = 16  # of a population
HOPELESS = 1e6  # cost of an undefined result


class Found(NamedTuple):
    """Result of a search."""

    shares: Floats  # the best numbers
    cost: float
    tries: int  # number of cost evaluations


def search(
    cost: Callable[[Floats], float], size: int, *, generations: int, seed: int, room: float = 1.0
) -> Found:
    """Minimize a cost.

    Args:
        cost: Function of numbers in [0, room]; values that are not finite count as worst.
        size: Number of variables.
        generations: After the first; the budget is ``MEMBERS * (generations + 1)`` tries.
        seed: Of the search.
        room: Largest value of each number.
    """
    result = differential_evolution(
        lambda shares: float(np.nan_to_num(cost(shares), nan=HOPELESS, posinf=HOPELESS)),
        [(0.0, room)] * size,
        init=room * qmc.Sobol(size, seed=seed).random(MEMBERS),
        maxiter=generations,
        tol=0.0,  # always the whole budget
        polish=False,
        rng=np.random.default_rng(seed),
    )
    return Found(result.x, float(result.fun), int(result.nfev))
