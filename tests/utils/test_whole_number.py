from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.utils.whole_number import whole_number
from tests.refusals import refused


@pytest.mark.parametrize("given", [3, np.int64(3), np.uint8(3)])
def test_whole_numbers_of_python_and_numpy_are_taken(given: Any) -> None:
    number = whole_number(given, "episodes", 1, 3)

    assert number == 3
    assert type(number) is int


@pytest.mark.parametrize("given", [0, 4, True, np.True_, 3.0, "3", None, [3]])
def test_anything_else_is_one_line(given: Any) -> None:
    with refused("episodes ... 1 to 3"):
        whole_number(given, "episodes", 1, 3)


def test_number_without_an_upper_bound_may_be_any() -> None:
    assert whole_number(10**30, "seed", 0) == 10**30
    with refused("seed ... -1 ... at least 0"):
        whole_number(-1, "seed", 0)
