from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.policies.constant import Constant


@pytest.mark.parametrize(
    ("shape", "expected"), [((12,), (1,)), ((7, 12), (7, 1)), ((0, 12), (0, 1))]
)
def test_action_has_the_shape_of_the_observations(
    shape: tuple[int, ...], expected: tuple[int, ...]
) -> None:
    action, state = Constant(0.75).predict(np.zeros(shape, dtype=np.float32), state="kept")

    assert action.shape == expected
    assert action.dtype == np.float32
    assert np.all(action == 0.5)
    assert state == "kept"


def test_fraction_beyond_the_nominal_speed_is_refused() -> None:
    with pytest.raises(ValueError, match="less than or equal to 1"):
        Constant(1.1)
