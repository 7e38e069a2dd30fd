"""Adapter from factories of single environments to one batch, for ``make_vec_env``.

``make_vec_env(id, n, vec_env_cls=CorridorVecEnv)`` passes factories that each make an environment
wrapped in a ``Monitor``. The batch runs their config, and forwards each world's steps to its
monitor, so that ``episode`` infos and the files of ``monitor_dir`` are those of single
environments.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any, cast

import gymnasium
import numpy as np
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker, TimeLimit

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.envs.batch_step import Bools
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.errors import InvalidInput, MissingExtra

try:
    from stable_baselines3.common.monitor import Monitor
except ImportError as error:
    raise MissingExtra("stable-baselines3", "train") from error

Functions = Sequence[Callable[[], Environment]]
PLAIN = (Monitor, TimeLimit, OrderEnforcing, PassiveEnvChecker)  # supported wrappers


class Singles:
    """Result of the factories: one config for all worlds, and their monitors.

    Attributes:
        config: Config of all worlds; a ``TimeLimit`` sets its horizon.
        spec: Spec of the first environment, None if not made by id.
        render_mode: Render mode of the first environment.
        action_space: Action space of the first environment, possibly seeded.
        monitors: One per world, or empty.
    """

    def __init__(self, functions: Functions) -> None:
        envs = [function() for function in functions]
        if not envs:
            raise InvalidInput("num_envs: given no function, allowed is at least one")
        layers = [_layers(env) for env in envs]
        self.config = _config_of(envs[0])
        if any(_config_of(env) != self.config for env in envs):
            raise InvalidInput("num_envs: given environments that differ, a batch has one config")
        self.spec = copy.deepcopy(envs[0].unwrapped.spec)
        self.render_mode: str | None = envs[0].render_mode
        self.action_space = envs[0].action_space
        self.monitors = [layer for each in layers for layer in each if isinstance(layer, Monitor)]
        if len(self.monitors) not in (0, len(envs)):
            raise InvalidInput("num_envs: given some environments with a Monitor, allowed: all")
        for monitor in self.monitors:
            monitor.env = _Told()

    def reset(self) -> None:
        """Forward a reset of all worlds to the monitors."""
        for monitor in self.monitors:
            monitor.reset()

    def note(self, rewards: Floats, terminated: Bools, truncated: Bools, infos: list[Info]) -> None:
        """Forward a step to the monitors, which add ``episode`` to the infos of ended episodes."""
        told = zip(rewards.tolist(), terminated.tolist(), truncated.tolist(), infos, strict=True)
        for monitor, step in zip(self.monitors, told, strict=False):
            cast(_Told, monitor.env).told = (None, *step)
            monitor.step(None)
            if monitor.needs_reset:
                monitor.reset()

    def close(self) -> None:
        """Close the monitors' files."""
        for monitor in self.monitors:
            monitor.close()


class _Told(Environment):
    """Stub environment of a monitor, which returns preset results."""

    told: object = None

    def reset(self, **arguments: object) -> tuple[None, Info]:
        return None, {}

    def step(self, action: object) -> Any:
        return self.told


def _layers(env: Environment) -> list[Environment]:
    """Return the wrappers of an environment; raise if one is not supported."""
    found: list[Environment] = []
    while isinstance(env, gymnasium.Wrapper):
        if type(env) not in PLAIN:
            raise InvalidInput(
                f"num_envs: given environments in {type(env).__name__}, allowed for a batch are "
                f"{', '.join(plain.__name__ for plain in PLAIN)}; wrap the batch itself instead"
            )
        found.append(env)
        env = env.env
    if not isinstance(env, CorridorEnv):
        raise InvalidInput(f"num_envs: given a {type(env).__name__}, allowed is CorridorEnv")
    return found


def _config_of(env: Environment) -> Config:
    config = cast(CorridorEnv, env.unwrapped).config
    limit = env.spec.max_episode_steps if env.spec else None
    steps = min(limit or np.inf, config.max_episode_steps)
    return make_config(config, max_episode_steps=int(steps))
