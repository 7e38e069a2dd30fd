"""Conversion of a policy's actions to an environment's action space."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import Policy
from hazbot_gym.task.action import nearest_level


def ask(
    policy: Policy,
    observation: Any,
    state: object = None,
    episode_start: npt.NDArray[np.bool_] | None = None,
) -> tuple[Any, object]:
    """Return a policy's most likely action and its next inner state.

    Raises:
        InvalidInput: The policy does not return an action and a state.
    """
    answer = policy.predict(
        observation, state=state, episode_start=episode_start, deterministic=True
    )
    if not isinstance(answer, tuple) or len(answer) != 2:
        kind = f"{len(answer)} values" if isinstance(answer, tuple) else type(answer).__name__
        raise InvalidInput(f"policy: predict returns {kind}, allowed is (action, state)")
    return answer


def playable(action: npt.NDArray[np.generic], space: gymnasium.Space[object]) -> object:
    """Return an action that fits an environment's space, the nearest level if discrete."""
    if not isinstance(space, gymnasium.spaces.Discrete):
        return action
    return int(levels_of(action, int(space.n))[0])


def levels_of(actions: npt.NDArray[np.generic], levels: int) -> npt.NDArray[np.int64]:
    """Return the index of the nearest level for speeds in [-1, 1]: (N, 1) to (N,).

    Integers are levels already.
    """
    values = np.asarray(actions).reshape(-1)
    if np.issubdtype(values.dtype, np.integer):
        return values.astype(np.int64)
    return nearest_level(values, levels)
