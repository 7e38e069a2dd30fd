"""Guard of every library policy: stop on an invalid observation or action.

An entry that is NaN, infinite or outside its documented bounds (``task/observation.py``) cannot
come from a working encoder, which clips to these bounds: a sensor has failed, or the units are
wrong. The action is then -1, stop; likewise if the policy's action is not finite. Rows of a batch
are independent. The inner state of a row is kept unchanged by an invalid observation; an episode
that begins with invalid observations begins, for the policy, with the first valid one. Observations
with a width that the library does not define are only checked for finite values.
"""

from __future__ import annotations

import math
import reprlib
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.observation import Layout, known_layout

Observations = npt.NDArray[np.float32]
Actions = npt.NDArray[np.float32]
Flags = npt.NDArray[np.bool_]

STOP = np.float32(-1.0)
ROUNDING = 1e-5  # tolerance of scaled bounds
_FINITE = np.finfo(np.float32)


class Guarded:
    """Guarded policy: calls ``act`` for valid observations, and stops otherwise.

    Subclass it to guard a user policy.
    """

    def act(
        self, observation: Observations, state: object, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the action and the next inner state for valid observations.

        Arguments and results are those of ``base.Policy.predict``. Arrays of the state, alone or in
        tuples, have the rows of a batch as their first axis.
        """
        raise NotImplementedError

    def predict(
        self,
        observation: Observations,
        state: object = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, object]:
        """Return the action, -1 for invalid observations; see ``base.Policy.predict``.

        Raises:
            InvalidInput: The observation is no numeric array, or ``episode_start`` has another
                length.
        """
        observation = numbers(observation)
        if episode_start is not None:
            episode_start = _flags(episode_start, observation.shape[:-1])
        if not observation.size:  # no rows
            return np.zeros((*observation.shape[:-1], 1), np.float32), state
        is_valid = valid(observation)
        if is_valid.all() and not isinstance(state, _Waiting):
            action, after = self.act(observation, state, episode_start, deterministic)
            if np.isfinite(action).all():
                return action, after
        return self._stop_where_invalid(observation, is_valid, state, episode_start, deterministic)

    def _stop_where_invalid(
        self,
        observation: Observations,
        is_valid: Flags,
        state: Any,
        episode_start: npt.NDArray[np.bool_] | None,
        deterministic: bool,
    ) -> tuple[Actions, object]:
        starts = np.zeros(is_valid.shape, np.bool_)
        if episode_start is not None:
            starts = starts | np.reshape(episode_start, starts.shape)
        if isinstance(state, _Waiting):
            state, starts = state.state, starts | state.rows
        safe = np.where(is_valid[..., None], observation, np.float32(0.0))
        action, after = self.act(safe, state, starts.reshape(-1), deterministic)
        works = is_valid & np.isfinite(action).all(axis=-1)
        action = np.where(works[..., None], action, STOP)
        if after is state:  # stateless policy
            return action, after
        begins_later = ~works & (starts | (state is None))
        if state is not None:
            after = _kept(state, after, ~works & ~begins_later)
        return action, _Waiting(after, begins_later) if begins_later.any() else after


class _Waiting(NamedTuple):
    """The state of a policy whose episode began with invalid observations."""

    state: object
    rows: Flags  # (...) True if the episode begins with the next valid observation


def numbers(observation: object) -> Observations:
    """Return an observation as an array (..., n) of real numbers, n at least 1."""
    try:
        entries = np.asarray(observation)
    except (TypeError, ValueError, RuntimeError) as error:  # RuntimeError: a tensor with gradients
        reason = str(error).splitlines()[0]
        raise InvalidInput(f"observation: given no array of numbers ({reason})") from error
    if entries.dtype.kind not in "biuf" or not entries.ndim or not entries.shape[-1]:
        raise InvalidInput(
            f"observation: given {entries.dtype} of shape {entries.shape}, allowed are numbers of "
            "shape (n,) or (N, n)"
        )
    return entries


def _flags(episode_start: Any, rows: tuple[int, ...]) -> Flags:
    """Return one flag for each observation (N,), from booleans or from 0 and 1."""
    count = math.prod(rows)
    flags = np.asarray(episode_start) if np.size(episode_start) == count else None
    if flags is not None and flags.dtype.kind in "biuf" and np.isin(flags, (0, 1)).all():
        return flags.astype(np.bool_).reshape(-1)
    given = reprlib.repr(episode_start)
    raise InvalidInput(f"episode_start: given {given}, allowed are booleans of shape ({count},)")


def valid(observation: npt.ArrayLike) -> Flags:
    """Return True for observations (..., n) within all bounds: shape (...)."""
    entries = np.asarray(observation)
    low, high = _bounds(known_layout(entries.shape[-1] if entries.ndim else 0))
    return np.asarray(((entries >= low) & (entries <= high)).all(axis=-1))  # NaN is neither


@cache
def _bounds(layout: Layout | None) -> tuple[Any, Any]:
    if layout is None:
        return _FINITE.min, _FINITE.max
    return layout.low - np.float32(ROUNDING), layout.high + np.float32(ROUNDING)


def _kept(old: Any, new: Any, rows: Flags) -> Any:
    """Return a state with some rows kept from before."""
    if old is new:
        return new
    if isinstance(new, tuple):
        parts = (_kept(*both, rows) for both in zip(old, new, strict=True))
        return type(new)(*parts) if hasattr(new, "_fields") else tuple(parts)
    return np.where(rows.reshape(rows.shape + (1,) * (np.ndim(new) - rows.ndim)), old, new)
