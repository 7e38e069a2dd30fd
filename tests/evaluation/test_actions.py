from __future__ import annotations

import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

from hazbot_gym.evaluation.actions import levels_of, playable


@pytest.mark.parametrize(("speed", "level"), [(-1, 0), (-0.6, 1), (0.1, 2), (0.9, 4), (1, 4)])
def test_a_speed_becomes_the_nearest_level_where_there_are_levels(speed: float, level: int) -> None:
    assert playable(np.array([speed], dtype=np.float32), Discrete(5)) == level
    assert playable(np.array([level]), Discrete(5)) == level


def test_a_speed_stays_as_it_is_where_there_are_none() -> None:
    action = np.array([0.3], dtype=np.float32)
    assert playable(action, Box(-1.0, 1.0, (1,))) is action


def test_stacked_speeds_become_one_level_each() -> None:
    assert levels_of(np.array([[-1.0], [0.1], [7.0]]), 5).tolist() == [0, 2, 4]
    assert levels_of(np.array([3, 1]), 5).tolist() == [3, 1]
