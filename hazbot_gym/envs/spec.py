"""An environment and Gymnasium's ``EnvSpec`` of it: one horizon, and arguments that JSON can hold.

The horizon of this package is ``config.max_episode_steps``. The ids are registered without one, as
Gymnasium would end episodes at that from outside, whatever the config says; so an environment's
spec is completed here by the true one, and what ``gymnasium.make`` was given goes to the config.
"""

from __future__ import annotations

import copy
import sys
from types import FrameType
from typing import Any, Protocol

import gymnasium
from gymnasium.envs.registration import EnvSpec
from pydantic_core import to_jsonable_python

from hazbot_gym.config import Config, plain


class _HasConfig(Protocol):
    config: Config


class CompleteSpec:
    """The attribute ``spec``, which Gymnasium sets after it has made an environment."""

    def __get__(self, env: _HasConfig | None, owner: type | None = None) -> EnvSpec | None:
        return None if env is None else env.__dict__.get("_complete_spec")

    def __set__(self, env: _HasConfig, spec: EnvSpec | None) -> None:
        if spec is not None:
            spec = copy.copy(spec)
            spec.max_episode_steps = env.config.max_episode_steps
            spec.kwargs = to_jsonable_python(plain(spec.kwargs))
        env.__dict__["_complete_spec"] = spec


def horizon_given_to_make(env: object) -> dict[str, Any]:
    """Return the ``max_episode_steps`` that ``gymnasium.make`` was given, as an override.

    ``make`` tells it to its TimeLimit only, which cannot make an episode longer and leaves no
    outcome in ``info``. To be called by the environment's constructor, which ``make`` calls
    itself, or through a subclass's constructor or a function; not one that another
    environment contains.
    """
    frame: FrameType | None = sys._getframe(2)
    while frame is not None and frame.f_code is not gymnasium.make.__code__:
        if frame.f_code.co_name == "__init__" and frame.f_locals.get("self") is not env:
            return {}
        frame = frame.f_back
    if frame is None:
        return {}
    given = frame.f_locals["max_episode_steps"]
    if given is None:
        given = frame.f_locals["env_spec"].max_episode_steps
    is_unlimited = given is None or given == -1  # -1: Gymnasium's "no TimeLimit"
    return {} if is_unlimited else {"max_episode_steps": given}
