"""hazbot_gym: choose the speed of a gas-inspection robot among people in narrow places.

Importing the package registers its environments with Gymnasium, without importing it: a robot needs
only ``SpeedController``. The names below are imported on first use, so that the import is fast.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from hazbot_gym.envs.registration import register_with_gymnasium

__version__ = "0.1.0"

if TYPE_CHECKING:
    from hazbot_gym.config import Config
    from hazbot_gym.core.own_terms import reward_term
    from hazbot_gym.core.own_walking import pedestrian_model
    from hazbot_gym.envs.corridor import CorridorEnv
    from hazbot_gym.evaluation.metrics import means, measure
    from hazbot_gym.evaluation.rollout import evaluate, run_episode
    from hazbot_gym.policies.base import make as make_policy
    from hazbot_gym.runtime.controller import SpeedController
    from hazbot_gym.task.observation import layout_of, observing
    from hazbot_gym.training.config import load_training
    from hazbot_gym.training.run import train

__all__ = [
    "Config",
    "CorridorEnv",
    "SpeedController",
    "evaluate",
    "layout_of",
    "load_training",
    "make_policy",
    "means",
    "measure",
    "observing",
    "pedestrian_model",
    "reward_term",
    "run_episode",
    "train",
]

_HOMES = {
    "Config": "config",
    "CorridorEnv": "envs.corridor",
    "SpeedController": "runtime.controller",
    "evaluate": "evaluation.rollout",
    "layout_of": "task.observation",
    "load_training": "training.config",
    "make_policy": "policies.base",
    "means": "evaluation.metrics",
    "measure": "evaluation.metrics",
    "observing": "task.observation",
    "pedestrian_model": "core.own_walking",
    "reward_term": "core.own_terms",
    "run_episode": "evaluation.rollout",
    "train": "training.run",
}

register_with_gymnasium()


def __getattr__(name: str) -> object:
    """Import a name of ``__all__`` when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_HOMES[name]}")
    return getattr(module, "make" if name == "make_policy" else name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
