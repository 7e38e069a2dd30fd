"""Mistakes in functions of users are refused in one line."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.hooks import NO_HOOK
from hazbot_gym.core.own_terms import REWARD_TERMS, reward_term
from hazbot_gym.core.own_walking import PEDESTRIAN_MODELS, address_of_model, pedestrian_model
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.reward import own_terms_in


@pytest.fixture(autouse=True)
def registers() -> Iterator[None]:
    """Forget what a test registers."""
    yield
    REWARD_TERMS.clear()
    PEDESTRIAN_MODELS.clear()


def undecorated(x: float) -> float:
    return x


def asks_for_a_field(robot: Any, people: Any, record: Any, rules: Any) -> float:
    return float(robot.speed)


def calls_a_plain_helper(robot: Any, people: Any, record: Any, rules: Any) -> float:
    return undecorated(robot.v)


def opens_a_file(robot: Any, people: Any, record: Any, rules: Any) -> float:
    with open("x") as file:
        return len(file.read())


def returns_nothing(robot: Any, people: Any, record: Any, rules: Any) -> None:
    pass


def returns_an_imaginary_number(robot: Any, people: Any, record: Any, rules: Any) -> complex:
    return 1j * float(robot.v)


def returns_text(robot: Any, people: Any, record: Any, rules: Any) -> str:
    return "much"


@pytest.mark.parametrize(
    ("term", "reason"),
    [
        (asks_for_a_field, "no field 'speed'"),
        (calls_a_plain_helper, "Untyped global name 'undecorated'"),
        (opens_a_file, "not supported"),
        (returns_nothing, "allowed is a number"),
        (returns_an_imaginary_number, "returns complex128, allowed is a number"),
        (returns_text, "allowed is a number"),
    ],
)
def test_a_term_that_cannot_be_compiled_is_refused(term: Callable[..., Any], reason: str) -> None:
    reward_term()(term)
    terms = own_terms_in(make_config(own_terms={term.__name__: 1.0}))

    with pytest.raises(InvalidInput, match=reason) as refused:
        terms.addresses()

    assert f"reward term '{term.__name__}'" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_term_is_compiled_once() -> None:
    @reward_term(low=-1.0, high=1.0)
    def wave(robot: Any, people: Any, record: Any, rules: Any) -> float:
        return math.sin(robot.s)

    first, second = (own_terms_in(make_config(own_terms={"wave": 1.0})) for _ in range(2))

    assert first.addresses() == second.addresses() != [NO_HOOK]


def test_a_model_that_returns_a_speed_only_is_refused() -> None:
    @pedestrian_model
    def fast(me: Any, situation: Any) -> Any:
        return me.desired_speed

    with pytest.raises(InvalidInput, match="'fast': returns float64, allowed is 2 numbers"):
        address_of_model("fast")


def test_wrong_parameters_are_refused() -> None:
    with pytest.raises(InvalidInput, match=r"takes \(robot, people\), allowed is \(robot, people"):
        reward_term()(lambda_with_a_name)
    with pytest.raises(InvalidInput, match=r"takes \(me\), allowed is \(me, situation\)"):
        pedestrian_model(alone)
    with pytest.raises(InvalidInput, match="given 3, allowed is a function"):
        reward_term()(3)  # type: ignore[type-var]


def test_a_function_that_writes_waits_or_yields_is_refused() -> None:
    def pushes(me: Any, situation: Any) -> tuple[float, float]:
        me.vx += 1.0
        return 0.0, 0.0

    async def waits(me: Any, situation: Any) -> Any:
        return 0.0, 0.0

    def yields(me: Any, situation: Any) -> Any:
        yield 0.0, 0.0

    with pytest.raises(InvalidInput, match=r"'pushes': writes .vx, allowed is to read \(line 1"):
        pedestrian_model(pushes)
    for function in (waits, yields):
        with pytest.raises(InvalidInput, match="waits or yields, allowed is a plain function"):
            pedestrian_model(function)


def test_the_fields_of_records_are_not_in_a_message() -> None:
    @pedestrian_model
    def asks(me: Any, situation: Any) -> Any:
        return situation.aheadx, 0.0

    with pytest.raises(InvalidInput) as refused:
        address_of_model("asks")

    assert "Unknown attribute 'aheadx' of type Situation (line" in str(refused.value)


def lambda_with_a_name(robot: Any, people: Any) -> float:
    return 0.0


def alone(me: Any) -> tuple[float, float]:
    return 0.0, 0.0


def test_names_that_are_taken_or_unknown_are_refused() -> None:
    def contact(robot: Any, people: Any, record: Any, rules: Any) -> float:
        return 0.0

    def replay(me: Any, situation: Any) -> tuple[float, float]:
        return 0.0, 0.0

    reward_term()(contact)
    with pytest.raises(InvalidInput, match="own_terms: given 'contact', which is a term of reward"):
        make_config(own_terms={"contact": 1.0})
    with pytest.raises(InvalidInput, match="own_terms: given 'comfort', registered .*: contact"):
        make_config(own_terms={"comfort": 1.0})
    with pytest.raises(InvalidInput, match="given 'replay', which is one of the library's"):
        pedestrian_model(replay)
    with pytest.raises(InvalidInput, match=r"people.model: given 'shy', allowed are 'scripted'"):
        make_config(people={"model": "shy"})


def test_a_term_without_arguments_of_the_decorator_is_from_0_to_1() -> None:
    @reward_term
    def half(robot: Any, people: Any, record: Any, rules: Any) -> float:
        return 0.5

    assert half(None, None, None, None) == 0.5
    assert REWARD_TERMS["half"][2:4] == (0.0, 1.0)


@pytest.mark.parametrize(
    ("low", "high"), [(1.0, 1.0), (2.0, 1.0), (0.0, np.inf), (np.nan, 1.0), ("0", 1.0), (0.0, None)]
)
def test_an_empty_range_is_refused(low: Any, high: Any) -> None:
    with pytest.raises(InvalidInput, match="allowed is low < high"):
        reward_term(low=low, high=high)
