"""The check of what a user's policy answers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.own_policy import OwnPolicy
from tests.refusals import refused

ONE, TWO = np.zeros(12, np.float32), np.zeros((2, 12), np.float32)


class Answers:
    """A policy that the same to everything."""

    def __init__(self, answer: Any) -> None:
        self._answer = answer

    def predict(self, *_: Any, **__: Any) -> Any:
        if isinstance(self._answer, BaseException):
            raise self._answer
        return self._answer


@pytest.mark.parametrize(
    ("observation", "action"),
    [
        (ONE, np.array([0.5], np.float32)),
        (ONE, [1.0000001]),
        (TWO, [[0.5], [-1.0]]),
        (TWO, np.array([3, 0])),  # levels
    ],
)
def test_an_action_is_handed_on_as_an_array(observation: Any, action: Any) -> None:
    found, state = OwnPolicy("mine:P", Answers((action, "state"))).predict(observation)
    np.testing.assert_array_equal(found, action)
    assert state == "state"


@pytest.mark.parametrize(
    ("observation", "answer", "complaint"),
    [
        (ONE, np.ones(1), "'mine:P' ... ndarray"),
        (ONE, (np.ones(1), None, 2), "'mine:P' ... 3 values"),
        (ONE, (0.5, None), "() ... (1,)"),
        (ONE, (np.ones((1, 1)), None), "(1, 1) ... (1,)"),
        (TWO, (np.ones(1), None), "(1,) ... (2, 1)"),
        (TWO, ([[1.0], [1.0, 2.0]], None), "'mine:P' ... ValueError"),
        (ONE, ([np.nan], None), "nan ... -1 <= action <= 1"),
        (TWO, (np.array([[0.0], [1.5]]), None), "1.5 ... -1 <= action <= 1"),
        (ONE, (["fast"], None), "<U4 ... numbers"),
        (ONE, ([None], None), "object ... numbers"),
        (ONE, ValueError("a\nb"), "'mine:P' ... ValueError: a b"),
        (ONE, SystemExit(3), "'mine:P' ... SystemExit: 3"),
    ],
)
def test_an_answer_that_is_no_action_is_one_line(
    observation: Any, answer: Any, complaint: str
) -> None:
    with refused(complaint):
        OwnPolicy("mine:P", Answers(answer)).predict(observation)
