from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.policies import make
from hazbot_gym.task.observation import LAYOUTS

TRACKS = LAYOUTS["tracks"]


def seen(*distances_m: float) -> np.ndarray:
    """Return an observation with people at some distances between centres."""
    observation = np.zeros(TRACKS.width, np.float32)
    for i, distance_m in enumerate(distances_m):
        for name, value in (("present", 1.0), ("distance_m", distance_m), ("bearing_cos", -1.0)):
            column = TRACKS.names.index(f"person{i}_{name}")
            observation[column] = value / TRACKS.fields[column].scale
    return observation


@pytest.mark.parametrize(
    ("distances_m", "action"),
    [((), 1.0), ((1.8,), 1.0), ((1.6,), -1.0), ((3.0, 1.6), -1.0)],
)
def test_it_stands_while_anybody_is_nearer_than_the_threshold(
    distances_m: tuple[float, ...], action: float
) -> None:
    policy = make("stop_when_near:stop_m=1.2")
    assert policy.predict(seen(*distances_m))[0] == pytest.approx([action])


def test_it_drives_at_its_fraction_of_the_nominal_speed_while_nobody_is_near() -> None:
    policy = make("stop_when_near:stop_m=1.2,fraction=0.6")
    assert policy.predict(seen(1.8))[0] == pytest.approx([0.2])
    assert policy.predict(seen(1.6))[0] == pytest.approx([-1.0])
