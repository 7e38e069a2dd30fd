from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.ttc import Ttc
from hazbot_gym.policies.velocity_obstacle import VelocityObstacle

Maker = Callable[..., Any]


@pytest.mark.parametrize(
    ("responsibility", "expected"),
    [
        (1.0, 0.6),  # 0.61 m in 2 s: below 0.305 m/s
        (0.5, 0.8),  # half the way there from 0.5 m/s: below 0.4025 m/s
        (0.25, 0.9),
    ],
)
def test_robot_makes_its_share_of_the_change(
    observe: Maker, share: Maker, responsibility: float, expected: float
) -> None:
    policy = VelocityObstacle(2.0, responsibility, margin_m=0.0)
    standing = observe((0.5 + 0.61, 0.0, 0.0, 0.0), v=0.5)
    assert share(policy, standing) == pytest.approx(expected)


def test_with_all_the_responsibility_it_is_the_ttc_rule_on_a_finer_grid(observe: Maker) -> None:
    rng = np.random.default_rng(1)
    people = rng.uniform([0.0, -2.0, -1.5, -1.5], [4.0, 2.0, 1.5, 1.5], (300, 4))
    rows = np.stack([observe(tuple(person), v=0.3) for person in people])
    fine = VelocityObstacle(3.0, 1.0, margin_m=0.3).predict(rows)[0]
    coarse = Ttc(3.0, margin_m=0.3).predict(rows)[0]
    assert np.all(fine >= coarse)
    assert np.all(coarse[fine == 1.0] == 1.0)
    assert np.any(fine > coarse)


def test_it_stops_where_every_speed_is_forbidden(observe: Maker, share: Maker) -> None:
    assert share(VelocityObstacle(), observe((1.5, 0.0, -1.3, 0.0), v=0.5)) == 0.0
