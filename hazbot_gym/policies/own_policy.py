"""Wrapper of a user policy that checks each call and each action.

A failing call or an invalid action raises a one-line error that names the policy; in a study, a
bare traceback would not.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies import own_module

ROUNDING = 1e-6  # float32 tolerance of action bounds


class OwnPolicy:
    """A user policy by ``module:attribute``.

    Attributes:
        spec: Its spec string.
        policy: The user's object with ``predict``.
    """

    def __init__(self, spec: str, policy: Any) -> None:
        self.spec, self.policy = spec, policy

    def predict(
        self,
        observation: npt.NDArray[np.float32],
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[npt.NDArray[Any], object]:
        """Return the user's action as an array, and the state; see ``base.Policy.predict``.

        Raises:
            InvalidInput: The call fails, or does not return an action and a state.
        """

        def ask() -> object:
            return self.policy.predict(
                observation, state=state, episode_start=episode_start, deterministic=deterministic
            )

        what = f"predict of {self.spec!r}"
        answer = own_module.called(what, ask)
        if not isinstance(answer, tuple) or len(answer) != 2:
            kind = f"{len(answer)} values" if isinstance(answer, tuple) else type(answer).__name__
            raise InvalidInput(f"policy: {what} returns {kind}, allowed is (action, state)")
        action = own_module.called(f"the action of {self.spec!r}", lambda: np.asarray(answer[0]))
        self._check(action, np.shape(observation)[:-1])
        return action, answer[1]

    def _check(self, action: npt.NDArray[np.generic], rows: tuple[int, ...]) -> None:
        """Reject an action of another shape or type, or out of bounds; integers are levels."""
        if action.shape not in ((*rows, 1), rows or (1,)):
            raise InvalidInput(
                f"policy: {self.spec!r} answers in shape {action.shape}, allowed is {(*rows, 1)}"
            )
        if action.dtype.kind not in "iuf":
            raise InvalidInput(f"policy: {self.spec!r} answers {action.dtype}, allowed are numbers")
        wrong = action[~(np.abs(action) <= 1.0 + ROUNDING)]  # NaN is wrong, too
        if action.dtype.kind == "f" and wrong.size:
            raise InvalidInput(
                f"policy: {self.spec!r} answers {wrong[0]}, allowed is -1 <= action <= 1"
            )
