"""Gymnasium ``EnvSpec`` of an environment: one horizon, and JSON-compatible arguments.

The horizon of this package is ``config.max_episode_steps``. The ids are registered without a
horizon, since Gymnasium's TimeLimit would override the config; this module completes the spec with
the config's horizon, and passes the horizon of ``gymnasium.make`` to the config.
"""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from types import FrameType
from typing import Protocol

import gymnasium
from gymnasium.envs.registration import EnvSpec
from pydantic_core import to_jsonable_python

from hazbot_gym.config import Config, horizon_in
from hazbot_gym.config.deltas import plain
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.json_object import JsonObject

HORIZON = "max_episode_steps"


class _HasConfig(Protocol):
    config: Config


class CompleteSpec:
    """Descriptor of the attribute ``spec``, which Gymnasium sets after construction."""

    def __get__(self, env: _HasConfig | None, owner: type | None = None) -> EnvSpec | None:
        return None if env is None else env.__dict__.get("_complete_spec")

    def __set__(self, env: _HasConfig, spec: EnvSpec | None) -> None:
        if spec is not None:
            spec = copy.copy(spec)
            spec.max_episode_steps = env.config.max_episode_steps
            spec.kwargs = to_jsonable_python(plain(spec.kwargs))
        env.__dict__["_complete_spec"] = spec


def horizon_given_to_make(env: object) -> dict[str, object]:
    """Return the ``max_episode_steps`` of ``gymnasium.make`` as an override.

    ``make`` passes it to its TimeLimit only, which cannot extend an episode and sets no outcome in
    ``info``. Call it in the environment's constructor, invoked by ``make`` directly or through a
    subclass's constructor or a function; not for an environment nested in another one.

    Raises:
        InvalidInput: The config has another horizon than the spec.
    """
    called = _locals_of(gymnasium.make, env)
    given = called.get("max_episode_steps")
    if given is not None:
        return {} if given == -1 else {"max_episode_steps": given}  # -1: "no TimeLimit"
    return horizon_of_spec(called["env_spec"], called["kwargs"]) if called else {}


def horizon_given_to_make_vec(env: object, overrides: JsonObject) -> JsonObject:
    """Return overrides of ``make_vec``, which include the horizon of a spec.

    Raises:
        InvalidInput: The config has another horizon.
    """
    called = _locals_of(gymnasium.make_vec, env)
    if not called or HORIZON in called["kwargs"] or HORIZON not in overrides:
        return overrides
    horizon = horizon_of_spec(called["env_spec"], called["kwargs"], overrides[HORIZON])
    return overrides | horizon


def horizon_of_spec(
    spec: EnvSpec, given: JsonObject, limit: int | None = None
) -> dict[str, object]:
    """Return the horizon of a spec as an override.

    Args:
        spec: Spec of the environment.
        given: Further arguments; config and scenario may set a horizon.
        limit: The spec's horizon, if it is among its arguments.

    Raises:
        InvalidInput: They set another horizon.
    """
    limit = spec.max_episode_steps if limit is None else limit
    if limit is None or limit == -1:
        return {}
    asked = horizon_in(given.get("config"), given.get("scenario"))
    if asked not in (None, limit):
        raise InvalidInput(
            f"{HORIZON}: given {asked!r} by config or scenario, but the spec of {spec.id} ends "
            f"episodes at {limit}; give {HORIZON} beside them, which counts for both"
        )
    return {HORIZON: limit}


def _locals_of(maker: Callable[..., object], env: object) -> JsonObject:
    """Return the local variables of the call of ``maker`` on the stack, if any.

    Call it one level below the environment's constructor.
    """
    frame: FrameType | None = sys._getframe(3)
    while frame is not None and frame.f_code is not maker.__code__:
        if frame.f_code.co_name == "__init__" and frame.f_locals.get("self") is not env:
            return {}
        frame = frame.f_back
    return {} if frame is None else dict(frame.f_locals)
