"""Validation of actions and reset options, shared by both engines."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

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


def options_of(options: object, *names: str) -> Mapping[object, object]:
    """Return the options of a reset, default an empty mapping.

    Raises:
        InvalidInput: They are no mapping, or an option is unknown.
    """
    if options is None:
        return {}
    allowed = " and ".join(names)
    if not isinstance(options, Mapping):
        given = reprlib.repr(options)
        raise InvalidInput(f"reset options: given {given}, allowed is a dict with {allowed}")
    unknown = [reprlib.repr(key).strip("'") for key in options if key not in names]
    if unknown:
        are = "is" if len(names) == 1 else "are"
        raise InvalidInput(f"reset options: given {', '.join(unknown)}, allowed {are} {allowed}")
    return options
