"""Validation of the inputs of a batch, as a whole before anything changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.arguments import array_of, options_of, overrides_of
from hazbot_gym.envs.batch_step import Bools
from hazbot_gym.envs.corridor import scenario_key_of
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.action import ACTION_TOLERANCE, SPEED_LEVELS
from hazbot_gym.utils.whole_number import whole_number

MOST = {"num_envs": 100_000, "threads": 1024}
Seeds = int | Sequence[int | None] | None


def count_of(given: object, name: str) -> int:
    """Return a number of worlds or threads."""
    return whole_number(given, name, 1, MOST[name])


def autoreset_mode_of(given: AutoresetMode | str) -> AutoresetMode:
    """Return the autoreset mode."""
    try:
        return AutoresetMode(given)
    except ValueError as error:
        allowed = ", ".join(mode.value for mode in AutoresetMode)
        raise InvalidInput(f"autoreset_mode: given {given!r}, allowed are {allowed}") from error


def actions_of(actions: object, worlds: int, config: Config) -> Floats:
    """Return the actions (N,) of N worlds in [-1, 1], up to rounding."""
    values = array_of(actions, "actions")
    if config.action_type == "discrete":
        levels = len(SPEED_LEVELS)
        is_level = values.dtype.kind in "iu" and np.all((values >= 0) & (values < levels))
        if values.shape != (worlds,) or not is_level:
            raise _wrong(values, f"{worlds} integers 0 to {levels - 1}")
        at_levels: Floats = 2.0 * np.array(SPEED_LEVELS)[values] - 1.0
        return at_levels
    if values.shape != (worlds, 1) or values.dtype.kind not in "iuf":
        raise _wrong(values, f"numbers of shape ({worlds}, 1)")
    checked: Floats = values[:, 0].astype(np.float64)
    is_allowed = np.abs(checked) <= 1.0 + ACTION_TOLERANCE  # NaN is not
    if not is_allowed.all():
        wrong = checked[~is_allowed][0]
        raise InvalidInput(f"actions: given {wrong}, allowed is -1 <= action <= 1")
    return checked


def _wrong(values: npt.NDArray[np.generic], allowed: str) -> InvalidInput:
    given = f"{values.dtype} of shape {values.shape}"
    return InvalidInput(f"actions: given {given}, allowed are {allowed}")


def reset_options_of(
    options: object, worlds: int
) -> tuple[Bools, list[int | None], Mapping[str, object]]:
    """Return a mask of worlds to reset, the requested scenario keys, if any, and config deltas."""
    options = options_of(options, "key", "config", "reset_mask")
    mask = np.ones(worlds, np.bool_)
    if "reset_mask" in options:
        mask = mask_of(options["reset_mask"], worlds, "reset_mask")
    if not mask.any():
        raise InvalidInput("reset_mask: given no world, allowed is at least one")
    return mask, _keys_of(options.get("key"), worlds), overrides_of(options)


def _keys_of(given: Any, worlds: int) -> list[int | None]:
    """Return one scenario key per world, from a number or a list; None for a random key."""
    is_listed = isinstance(given, list | tuple | np.ndarray)
    keys = list(given) if is_listed else [given] * worlds
    if len(keys) != worlds:
        raise InvalidInput(f"reset options: given {len(keys)} keys for {worlds} worlds")
    return [None if key is None else scenario_key_of(key) for key in keys]


def mask_of(given: Any, worlds: int, name: str) -> Bools:
    """Return a mask of worlds."""
    if not isinstance(given, np.ndarray) or given.shape != (worlds,) or given.dtype != np.bool_:
        what = f"{given.dtype} of shape {given.shape}" if hasattr(given, "dtype") else repr(given)
        raise InvalidInput(f"{name}: given {what}, allowed is a boolean array of shape ({worlds},)")
    return given


def seeds_of(given: Seeds, worlds: int) -> list[int | None]:
    """Return one seed for each world: a number counts up, None keeps the generators."""
    if given is None:
        return [None] * worlds
    if isinstance(given, int | np.integer) and not isinstance(given, bool):
        given = range(int(given), int(given) + worlds)
    elif isinstance(given, str) or not np.iterable(given):
        whole_number(given, "seed", 0)
    seeds = list(cast(Sequence[int | None], given))
    if len(seeds) != worlds:
        raise InvalidInput(f"seed: given {len(seeds)} seeds for {worlds} worlds")
    return [None if seed is None else whole_number(seed, "seed", 0) for seed in seeds]


def generator_of(seed: int | None) -> tuple[np.random.Generator, int]:
    """Return the generator of ``CorridorEnv`` after ``reset(seed=seed)``, and its seed."""
    return np_random(seed)
