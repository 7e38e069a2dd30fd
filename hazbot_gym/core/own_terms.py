"""Reward terms of users, registered by name with ``@reward_term``."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from numbers import Real
from typing import NamedTuple, TypeVar, overload

from hazbot_gym.core.hooks import check_hook
from hazbot_gym.core.jit import scalar
from hazbot_gym.errors import InvalidInput

PARAMETERS = ("robot", "people", "record", "rules")
Term = TypeVar("Term", bound=Callable[..., float])


class RewardTerm(NamedTuple):
    """A registered term.

    Attributes:
        name: Its name in ``info["reward_terms"]`` and in ``own_terms`` of the config.
        function: From the records of robot (ROBOT), people (P,) PERSON and decision (STEP), and
            ``Rules``, to the unweighted term.
        low: Lower end of its range.
        high: Upper end.
        meaning: First line of its docstring.
    """

    name: str
    function: Callable[..., float]
    low: float
    high: float
    meaning: str


REWARD_TERMS: dict[str, RewardTerm] = {}  # registered in this process


@overload
def reward_term(function: Term, /) -> Term: ...


@overload
def reward_term(*, low: float = 0.0, high: float = 1.0) -> Callable[[Term], Term]: ...


def reward_term(
    function: Term | None = None, /, *, low: float = 0.0, high: float = 1.0
) -> Term | Callable[[Term], Term]:
    """Register a function ``(robot, people, record, rules)`` as a reward term.

    Both engines call it after each decision; the batched one compiles it. The weight is set in the
    config: ``own_terms={"name_of_the_function": -0.5}``.

    Args:
        function: The function, where the decorator stands without parentheses.
        low: Lower end of its range; a smaller value raises an error.
        high: Upper end; a larger value raises an error.

    Raises:
        InvalidInput: The function takes other parameters, its name is taken, or the range is empty.
    """
    are_numbers = all(isinstance(end, Real) for end in (low, high))
    if not (are_numbers and -math.inf < low < high < math.inf):
        raise InvalidInput(f"reward_term: given low={low!r}, high={high!r}, allowed is low < high")

    def register(function: Term) -> Term:
        name = check_hook("reward_term", function, PARAMETERS, ())
        meaning = (inspect.getdoc(function) or "").partition("\n")[0]
        REWARD_TERMS[name] = RewardTerm(name, function, low, high, meaning)
        return scalar(function)

    return register if function is None else register(function)


def check_terms(weights: Mapping[str, float]) -> Mapping[str, float]:
    """Raise ``ValueError`` if one of the terms is not registered."""
    for name in weights:
        if name not in REWARD_TERMS:
            known = ", ".join(REWARD_TERMS) or "none so far"
            raise ValueError(f"given {name!r}, registered with @reward_term: {known}")
    return weights
