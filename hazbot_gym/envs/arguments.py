"""Validation of actions and reset options, shared by both engines."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.config.deltas import as_mappings
from hazbot_gym.config.randomised import check_same
from hazbot_gym.errors import InvalidInput

Environment = gymnasium.Env[Any, Any]  # any of Gymnasium, also wrapped
Batch = gymnasium.vector.VectorEnv[Any, Any, Any]  # the same for batches
Info = dict[str, Any]  # Gymnasium's: values of several kinds by name


def array_of(actions: object, name: str) -> npt.NDArray[Any]:
    """Return actions as an array.

    Raises:
        InvalidInput: They do not form an array, such as lists of different lengths.
    """
    try:
        return np.asarray(actions)
    except (TypeError, ValueError, RuntimeError) as error:  # RuntimeError: a tensor with gradients
        reason = str(error).splitlines()[0]
        raise InvalidInput(f"{name}: given {reprlib.repr(actions)}, no array ({reason})") from error


def overrides_of(options: Mapping[object, object]) -> Mapping[str, object]:
    """Return the config deltas of a reset's options, default an empty mapping."""
    deltas = options.get("config", {})
    if not isinstance(deltas, Mapping) or not all(isinstance(name, str) for name in deltas):
        raise InvalidInput(
            f"reset options: config: given {reprlib.repr(deltas)}, allowed is a mapping of deltas"
        )
    return deltas


def episode_base(config: Config, deltas: Mapping[str, object]) -> Config:
    """Return the config of the episodes of a reset, which may still be randomised.

    Raises:
        InvalidInput: A value cannot be used, or must be the same in all episodes.
    """
    if not deltas:
        return config
    changed = make_config(deltas, preset=as_mappings(config))
    check_same(config, changed)
    return changed


def options_of(options: object, *names: str) -> Mapping[object, object]:
    """Return the options of a reset, default an empty mapping.

    Raises:
        InvalidInput: They are no mapping, or an option is unknown.
    """
    if options is None:
        return {}
    allowed = f"{', '.join(names[:-1])} and {names[-1]}"
    if not isinstance(options, Mapping):
        given = reprlib.repr(options)
        raise InvalidInput(f"reset options: given {given}, allowed is a dict with {allowed}")
    unknown = [reprlib.repr(key).strip("'") for key in options if key not in names]
    if unknown:
        raise InvalidInput(f"reset options: given {', '.join(unknown)}, allowed are {allowed}")
    return options
