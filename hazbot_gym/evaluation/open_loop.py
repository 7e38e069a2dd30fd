"""Open-loop plan: a fixed action sequence. The oracles of a study are such plans."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.guard import Actions, Observations


class Plan:
    """Open-loop policy: replays actions in [-1, 1] in order and then holds the last action."""

    def __init__(self, actions: Floats) -> None:
        """Store the actions (T,) of one plan, or (N, T) of one plan per world."""
        self._actions = np.atleast_2d(np.asarray(actions, dtype=np.float32))

    def predict(
        self,
        observation: Observations,
        state: int | None = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, int]:
        """Return each world's next action and the number of the decision; see ``Policy.predict``.

        All worlds start together.
        """
        t = state or 0
        now = self._actions[:, min(t, self._actions.shape[1] - 1)]
        rows = len(observation) if np.ndim(observation) > 1 else 1
        actions: Actions = np.broadcast_to(now, rows).reshape(rows, 1).copy()
        return (actions if np.ndim(observation) > 1 else actions[0]), t + 1
