"""From what a policy answers to what an environment takes."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt


def playable(action: npt.NDArray[Any], space: gymnasium.Space[Any]) -> Any:
    """Return an action that fits one environment's space: the nearest level where it has levels."""
    if not isinstance(space, gymnasium.spaces.Discrete):
        return action
    return int(levels_of(action, int(space.n))[0])


def levels_of(actions: npt.NDArray[Any], levels: int) -> npt.NDArray[np.int64]:
    """Return the nearest of some levels, numbered from 0, for speeds in [-1, 1]: (N, 1) to (N,).

    Integers are levels already.
    """
    values = np.asarray(actions).reshape(-1)
    if np.issubdtype(values.dtype, np.integer):
        return values.astype(np.int64)
    top = levels - 1
    return np.clip(np.rint((values + 1) / 2 * top), 0, top).astype(np.int64)
