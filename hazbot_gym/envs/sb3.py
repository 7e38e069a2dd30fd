"""The batched environment as Stable-Baselines3 wants it.

SB3 resets a world in the very step in which its episode ends and hands the last observation over as
``terminal_observation``; ``TimeLimit.truncated`` tells it to bootstrap the value there. That is
Gymnasium's SAME_STEP mode in another dress, so this file only translates.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode

from hazbot_gym.core.state import Floats
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.reward import TERMS

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("stable-baselines3", "train") from error


class CorridorVecEnv(VecEnv):
    """N corridor worlds for SB3, VecMonitor and VecNormalize.

    Attributes:
        terms: (N, 7) unweighted reward terms of the last decision, in the order of ``TERMS``.
        costs: (N,) its safety costs.

    Example:
        >>> from hazbot_gym.envs.sb3 import CorridorVecEnv
        >>> envs = CorridorVecEnv(4, seed=0)
        >>> envs.reset().shape
        (4, 48)
    """

    def __init__(self, num_envs: int, *, seed: int | None = None, **arguments: Any) -> None:
        """Make N worlds; ``arguments`` are those of ``CorridorVectorEnv``."""
        self.worlds = CorridorVectorEnv(
            num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **arguments
        )
        self.render_mode = None
        self._seed_next = seed
        self._actions: npt.NDArray[Any] | None = None
        self.terms, self.costs = np.zeros((num_envs, len(TERMS))), np.zeros(num_envs)
        super().__init__(
            num_envs, self.worlds.single_observation_space, self.worlds.single_action_space
        )

    def reset(self) -> npt.NDArray[np.float32]:
        """Start new episodes in all worlds; a seed is used once."""
        observations, info = self.worlds.reset(seed=self._seed_next)
        self._seed_next = None
        self.reset_infos = [_reset_info(info, i) for i in range(self.num_envs)]
        return observations

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the worlds at the next reset: world i with ``seed + i``."""
        self._seed_next = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def step_async(self, actions: npt.NDArray[Any]) -> None:
        """Note the actions."""
        self._actions = actions

    def step_wait(self) -> tuple[npt.NDArray[np.float32], Any, Any, list[dict[str, Any]]]:
        """Take one decision in every world."""
        observations, rewards, terminated, truncated, info = self.worlds.step(self._actions)
        ended = terminated | truncated
        self.terms, self.costs = _decision_of(info)
        infos: list[dict[str, Any]] = [{"cost": cost} for cost in self.costs.tolist()]
        for i in np.flatnonzero(ended):
            last = info["final_info"]
            infos[i] |= {
                "terminal_observation": info["final_obs"][i],
                "outcome": last["outcome"][i],
                "reward_terms": {name: float(last["reward_terms"][name][i]) for name in TERMS},
                "TimeLimit.truncated": bool(truncated[i]),
            }
            self.reset_infos[i] = _reset_info(info, i)
        return observations, rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Release the threads."""
        self.worlds.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the worlds, the same for each of them."""
        return [getattr(self.worlds, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: the worlds share one config, which is frozen."""
        raise InvalidInput(f"set_attr: given {attr_name!r}, the worlds of a batch are not changed")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Refuse: there are no single environments behind the batch."""
        raise InvalidInput(f"env_method: given {method_name!r}, there are no single environments")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Tell that no world is wrapped."""
        return [False for _ in self._get_indices(indices)]


def _decision_of(info: dict[str, Any]) -> tuple[Floats, Floats]:
    """Return terms and costs of a decision in all worlds; an end that was reset tells its own."""
    tellers = [info, info["final_info"]] if "final_info" in info else [info]  # each 0 elsewhere
    terms = sum(np.stack([teller["reward_terms"][name] for name in TERMS], 1) for teller in tellers)
    return terms, sum(teller["cost"] for teller in tellers)


def _reset_info(info: dict[str, Any], i: int) -> dict[str, Any]:
    return {
        "scenario_key": int(info["scenario_key"][i]),
        "place": info["place"][i],
        "time_free_s": float(info["time_free_s"][i]),
    }
