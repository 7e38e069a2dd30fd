"""Stable-Baselines3 ``VecEnv`` adapter of the batched environment.

SB3 resets a world in the step in which its episode ends, and expects the last observation as
``terminal_observation`` and ``TimeLimit.truncated`` for bootstrapping. This corresponds to
Gymnasium's SAME_STEP mode, so this file only translates.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from hazbot_gym.core.state import Floats
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import NAMESPACE
from hazbot_gym.envs.sb3_singles import Functions, Singles
from hazbot_gym.envs.spec import horizon_of_spec
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.leak import gas_info
from hazbot_gym.task.reward import terms_of
from hazbot_gym.utils.whole_number import whole_number

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("stable-baselines3", "train") from error

DEFAULT_ID = f"{NAMESPACE}/Corridor-v1"
PICTURED = 9  # worlds per picture


class CorridorVecEnv(VecEnv):
    """N corridor worlds for SB3, VecMonitor and VecNormalize.

    Infos are those of single environments. ``render`` tiles the first nine worlds.

    Attributes:
        terms: (N, 7) unweighted reward terms of the last decision, in the order of ``TERMS``; with
            gas (N, 8).
        costs: (N,) its safety costs.

    Example:
        >>> from hazbot_gym.envs.sb3 import CorridorVecEnv
        >>> envs = CorridorVecEnv(4, seed=0)
        >>> envs.reset().shape
        (4, 51)
    """

    def __init__(
        self,
        num_envs: int | Functions,
        *,
        id: str | None = None,
        seed: int | None = None,
        has_infos: bool = True,
        **arguments: Any,
    ) -> None:
        """Make N worlds.

        Args:
            num_envs: Number of worlds; or, as from ``make_vec_env``, factories of single
                environments, whose config and monitors the batch takes over.
            id: A registered environment, such as ``hazbot_gym/Crossing-v1``.
            seed: World i is seeded by ``seed + i`` at the first reset.
            has_infos: Whether running worlds have infos; without them steps are faster. Infos of
                resets and of ended episodes are always there.
            **arguments: Arguments of ``CorridorVectorEnv``.

        Raises:
            InvalidInput: A value cannot be used; one line says which and what is allowed.
        """
        self._has_infos = has_infos
        self._singles = Singles(num_envs) if isinstance(num_envs, list | tuple) else None
        spec = _spec_of(id or DEFAULT_ID)
        if self._singles:
            if id is not None:
                raise InvalidInput(f"id: given {id!r} and functions of environments, allowed: one")
            spec = self._singles.spec or spec
            given = {"config": self._singles.config, "render_mode": self._singles.render_mode}
            arguments = {**given, **arguments}
        elif id is not None:
            is_said = "max_episode_steps" in arguments
            horizon = {} if is_said else horizon_of_spec(spec, arguments)
            arguments = {**spec.kwargs, **horizon, **arguments}
        count = len(num_envs) if isinstance(num_envs, list | tuple) else cast(int, num_envs)
        self.worlds = CorridorVectorEnv(count, autoreset_mode=AutoresetMode.SAME_STEP, **arguments)
        spec.max_episode_steps = self.worlds.config.max_episode_steps
        spec.kwargs = {"config": self.worlds.config.model_dump(mode="json")}
        self.spec = spec
        self._actions: npt.NDArray[np.generic] | None = None
        self._term_names = terms_of(self.worlds.config)
        self.terms, self.costs = np.zeros((count, len(self._term_names))), np.zeros(count)
        actions = self.worlds.single_action_space
        if self._singles and self._singles.action_space == actions:
            actions = self._singles.action_space  # seeded by make_vec_env
        super().__init__(count, self.worlds.single_observation_space, actions)
        self.metadata = CorridorEnv.metadata | {"render_fps": self.worlds.metadata["render_fps"]}
        if seed is not None:
            self.seed(seed)

    def reset(self) -> npt.NDArray[np.float32]:
        """Start new episodes in all worlds; seeds and options apply once."""
        options = None
        if any(self._options):
            options = _common(self._options)
        observations, info = self.worlds.reset(seed=self._seeds, options=options)
        self._reset_seeds()
        self._reset_options()
        if self._singles:
            self._singles.reset()
        self.reset_infos = _by_world(info)
        self._starts = [_running(start) for start in self.reset_infos]
        return observations

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed world i by ``seed + i`` at the next reset."""
        return super().seed(None if seed is None else whole_number(seed, "seed", 0))

    def set_options(self, options: list[Info] | Info | None = None) -> None:
        """Set the options of the next reset: one dictionary for all worlds, or one per world."""
        each = options if isinstance(options, list | tuple) else [options or {}] * self.num_envs
        if len(each) != self.num_envs or not all(isinstance(one, dict) for one in each):
            raise InvalidInput(
                f"reset options: given {options!r}, allowed is a dict, or a list of one a world"
            )
        super().set_options(list(each))

    def step_async(self, actions: npt.NDArray[np.generic]) -> None:
        """Store the actions."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.bool_], list[Info]]:
        """Take one decision in every world."""
        if not self._has_infos and not self._singles:
            return self._step_arrays()
        observations, rewards, terminated, truncated, info = self.worlds.step(self._actions)
        ended = terminated | truncated
        ends = np.flatnonzero(ended)
        self.terms, self.costs = _decision_of(info, self._term_names)
        infos = self._infos(info["time_s"])
        if len(ends):
            self.note_resets(info, ends)
            for i, end in zip(ends, _by_world(info["final_info"], ends), strict=True):
                infos[i] = end | {"TimeLimit.truncated": bool(truncated[i])}
        if self._singles:
            self._singles.note(rewards, terminated, truncated, infos)
        for i in ends:
            infos[i]["terminal_observation"] = info["final_obs"][i]
        return observations, rewards.astype(np.float32), ended, infos

    def _step_arrays(
        self,
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.bool_], list[Info]]:
        """Take one decision in every world; running worlds share one empty info."""
        step = self.worlds.step_arrays(self._actions)
        self.terms, self.costs = self.worlds.terms, self.worlds.costs
        infos: list[Info] = [{}] * self.num_envs
        if len(step.rows):
            fresh, last = _by_world(step.info), _by_world(step.info["final_info"])
            for k, i in enumerate(step.rows.tolist()):
                self.reset_infos[i] = fresh[k]
                infos[i] = last[k] | {
                    "TimeLimit.truncated": bool(step.truncated[i]),
                    "terminal_observation": step.info["final_obs"][k],
                }
        return step.observations.copy(), step.rewards.astype(np.float32), step.ended, infos

    def note_resets(self, info: Info, rows: npt.NDArray[np.int64]) -> None:
        """Take over the infos of worlds that were reset in a step of ``worlds``."""
        for i, start in zip(rows.tolist(), _by_world(info, rows), strict=True):
            self.reset_infos[i], self._starts[i] = start, _running(start)

    def _infos(self, time_s: Floats) -> list[Info]:
        """Return the infos of running worlds: those of their resets with updates."""
        blank = [dict.fromkeys(self._term_names)] * self.num_envs
        terms = _filled(blank, dict(zip(self._term_names, self.terms.T.tolist(), strict=True)))
        changed = {"time_s": time_s.tolist(), "reward_terms": terms, "cost": self.costs.tolist()}
        if self.worlds.config.gas is not None:
            gas = gas_info(self.worlds.state().gas)
            columns = {name: values.tolist() for name, values in gas.items()}
            changed["gas"] = _filled([dict.fromkeys(columns)] * self.num_envs, columns)
        return _filled(self._starts, changed)

    def close(self) -> None:
        """Release the threads, and close the monitors' files; idempotent."""
        self.worlds.close()
        if self._singles:
            self._singles.close()

    def get_images(self) -> Sequence[npt.NDArray[np.uint8] | None]:
        """Return pictures (H, W, 3) of the first nine worlds, with ``render_mode="rgb_array"``."""
        return self.worlds.pictures(range(min(self.num_envs, PICTURED))) or []

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of some worlds, as of single environments."""
        is_mine = attr_name in ("observation_space", "action_space", "metadata", "spec")
        value = getattr(self if is_mine else self.worlds, attr_name)
        if callable(value):
            raise AttributeError(f"{attr_name}: there are no single environments behind a batch")
        is_listed = attr_name in ("np_random", "np_random_seed") and isinstance(value, tuple)
        values = value if is_listed else [value] * self.num_envs
        return [values[i] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: object, indices: object = None) -> None:
        """Not supported: the worlds share one frozen config."""
        raise InvalidInput(f"set_attr: given {attr_name!r}, the worlds of a batch are not changed")

    def env_method(
        self, method_name: str, *args: object, indices: object = None, **kwargs: object
    ) -> Any:
        """Not supported: the batch has no single environments."""
        raise InvalidInput(f"env_method: given {method_name!r}, there are no single environments")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """Return True for each world wrapped in a class: in ``Monitor`` if its factory used it."""
        is_monitored = self._singles is not None and bool(self._singles.monitors)
        is_wrapped = is_monitored and issubclass(Monitor, wrapper_class)
        return [is_wrapped for _ in self._get_indices(indices)]


def _spec_of(env_id: str) -> EnvSpec:
    """Return a copy of the spec of an id, which must be an environment of this package."""
    try:
        spec = gymnasium.spec(env_id)
    except (gymnasium.error.Error, TypeError) as error:  # TypeError: no text
        raise InvalidInput(f"id: given {env_id!r}, which is not registered") from error
    if spec.vector_entry_point != gymnasium.spec(DEFAULT_ID).vector_entry_point:
        raise InvalidInput(f"id: given {env_id!r}, allowed are ids of {NAMESPACE}")
    return copy.deepcopy(spec)


def _common(options: list[Info]) -> Info:
    """Merge the options of all worlds into those of a batch."""
    unknown = sorted({str(name) for each in options for name in each} - {"key", "config"})
    if unknown:
        raise InvalidInput(f"reset options: given {', '.join(unknown)}, allowed are key and config")
    deltas = [each.get("config", {}) for each in options]
    if any(each != deltas[0] for each in deltas):
        raise InvalidInput(
            "reset options: config: given different ones, allowed is the same for all"
        )
    return {"key": [each.get("key") for each in options], "config": deltas[0]}


def _decision_of(info: Info, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Return terms and costs of a decision in all worlds, from ``final_info`` for ended ones."""
    tellers = [info, info["final_info"]] if "final_info" in info else [info]  # each 0 elsewhere
    terms = sum(np.stack([teller["reward_terms"][name] for name in names], 1) for teller in tellers)
    return cast(Floats, terms), sum(teller["cost"] for teller in tellers)


def _by_world(info: Info, which: object = slice(None)) -> list[Info]:
    """Return one info per world, in the format of single environments."""
    names = [name for name in info if not name.startswith(("_", "final_"))]
    columns = [
        _by_world(info[name], which) if isinstance(info[name], dict) else info[name][which].tolist()
        for name in names
    ]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def _running(start: Info) -> Info:
    """Return the info of a running world, from the info of its reset."""
    return start | {"TimeLimit.truncated": False}


def _filled(blank: list[Info], columns: dict[str, list[Any]]) -> list[Info]:
    """Return dictionaries filled from columns, one per row (fastest way)."""
    filled = [each.copy() for each in blank]
    for name, column in columns.items():
        for each, value in zip(filled, column, strict=True):
            each[name] = value
    return filled
