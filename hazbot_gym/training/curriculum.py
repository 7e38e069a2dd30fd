"""Curriculum: values of the environments' config that change during training.

They change when an interval of a run begins, where all episodes start anew (``callbacks.py``). They
are a function of the decisions taken and of the validations so far, both of which a checkpoint has,
so that a resumed run is bit-identical.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from hazbot_gym.envs.arguments import episode_base
from hazbot_gym.errors import InvalidInput
from hazbot_gym.training.config import Stage, TrainConfig
from hazbot_gym.training.priced_rewards import fixed_price

Validations = Sequence[Mapping[str, Any]]
Curriculum = Callable[[int, Validations], Mapping[str, object]]


def by_steps(stages: Sequence[Stage]) -> Curriculum:
    """Return the curriculum of stages: the overrides of the last one that has begun."""

    def overrides(step: int, validations: Validations) -> Mapping[str, object]:
        begun = [stage for stage in stages if stage.from_step <= step]
        return begun[-1].overrides if begun else {}

    return overrides


def curriculum_of(config: TrainConfig, given: Curriculum | None) -> Curriculum | None:
    """Return the curriculum of a run, if any.

    Raises:
        InvalidInput: There are two, the engine cannot change, or a stage is not allowed.
    """
    if given is None and not config.curriculum:
        return None
    if given is not None and not _takes_two(given):
        allowed = "a function of the decisions and validations so far"
        raise InvalidInput(f"curriculum: given {given!r}, allowed is {allowed}")
    if given is not None and config.curriculum:
        raise InvalidInput("curriculum: given in the config and as a function, allowed is one")
    if config.engine != "batched":
        raise InvalidInput(f"curriculum: given with engine {config.engine!r}, allowed is 'batched'")
    for stage in config.curriculum:
        check_overrides(config, stage.overrides)
    return given or by_steps(config.curriculum)


def _takes_two(given: object) -> bool:
    """Return True for what can be called with two arguments."""
    try:
        inspect.signature(given).bind(0, [])  # type: ignore[arg-type]  # TypeError if no function
    except TypeError:
        return False
    except ValueError:  # some built-in functions have no signature
        return callable(given)
    return True


def check_overrides(config: TrainConfig, overrides: object) -> None:
    """Raise if overrides of a curriculum are not allowed in one of the environments."""
    if not isinstance(overrides, Mapping):
        raise InvalidInput(f"curriculum: given {overrides!r}, allowed is a mapping of overrides")
    for base in config.environments():
        try:
            changed = episode_base(base, overrides)
        except InvalidInput as error:
            raise InvalidInput(f"curriculum: {error}") from error
        if config.prices and fixed_price(changed) != fixed_price(base):
            raise InvalidInput("curriculum: given another reward.intrusion, which prices set")
