"""NumericInfo: numeric, flat infos for clients such as TorchRL."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import VectorWrapper

from hazbot_gym.envs.arguments import Batch, Info

ENDS = ("final_obs", "_final_obs", "_final_info")  # of ended episodes, passed on unchanged


class NumericInfo(VectorWrapper):  # not generic in Gymnasium 1.1
    """Vector wrapper: keeps numeric infos only, nested entries as ``reward_terms/progress``.

    TorchRL 0.14 reads the infos of vector environments with SAME_STEP resets, and fails for text or
    dictionaries in any environment.

    Example:
        >>> import gymnasium, hazbot_gym
        >>> from hazbot_gym.envs.numeric_info import NumericInfo
        >>> envs = NumericInfo(gymnasium.make_vec(
        ...     "hazbot_gym/Corridor-v1", 2, "vector_entry_point", autoreset_mode="SameStep"
        ... ))
        >>> _, info = envs.reset(seed=0)
        >>> "outcome" in info, info["reward_terms/progress"].tolist()
        (False, [0.0, 0.0])
    """

    def __init__(self, env: Batch) -> None:
        super().__init__(env)
        self.autoreset_mode = env.metadata["autoreset_mode"]  # TorchRL reads the outermost

    def reset(self, **arguments: Any) -> tuple[Any, Info]:
        """Start new episodes."""
        observations, info = self.env.reset(**arguments)
        return observations, _numbers(info)

    def step(self, actions: object) -> tuple[object, object, object, object, Info]:
        """Take one decision in every world."""
        *told, info = self.env.step(actions)
        return *told, _numbers(info)


def _numbers(info: Info, prefix: str = "") -> Info:
    """Return the numeric arrays, flattened; under ``final_info`` those of ended episodes."""
    kept: Info = {}
    for name, value in info.items():
        if name == "final_info":
            kept[name] = _numbers(value)
        elif name in ENDS:
            kept[name] = value
        elif isinstance(value, dict):
            kept |= _numbers(value, f"{name}/")
        elif not name.startswith("_") and np.asarray(value).dtype != object:
            kept[prefix + name] = value
    return kept
