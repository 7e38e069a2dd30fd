from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.passive_safety import PassiveSafety, safe_speed
from hazbot_gym.policies.people_seen import RADII_M
from hazbot_gym.policies.robot import ACCELERATION_MPS2 as A
from hazbot_gym.policies.robot import BRAKING_MPS2 as B
from hazbot_gym.policies.robot import DECISION_S as EPS

Maker = Callable[..., Any]


@pytest.mark.parametrize("obstacle_mps", [0.0, 0.7, 1.6])
def test_speed_is_the_largest_that_the_published_bound_permits(obstacle_mps: float) -> None:
    d, u = np.linspace(0.5, 5.0, 30), obstacle_mps
    v = safe_speed(d, u)
    bound_m = v**2 / (2 * B) + u * v / B + (A / B + 1) * (A * EPS**2 / 2 + EPS * (v + u))
    np.testing.assert_allclose(bound_m, d)


@pytest.mark.parametrize("obstacle_mps", [0.0, 0.7, 1.6])
@pytest.mark.parametrize("d", [0.4, 0.8, 2.0])
def test_robot_that_gains_speed_for_a_decision_and_brakes_then_stands_before_it_is_reached(
    obstacle_mps: float, d: float
) -> None:
    v = float(safe_speed(d, obstacle_mps))
    fastest = v + A * EPS
    way_m = v * EPS + A * EPS**2 / 2 + fastest**2 / (2 * B)
    met_m = obstacle_mps * (EPS + fastest / B)
    assert v > 0.0
    assert way_m + met_m == pytest.approx(d)  # the bound is tight


def test_too_near_is_no_speed() -> None:
    assert safe_speed([0.0, -1.0, 0.1], 1.6).tolist() == [0.0, 0.0, 0.0]


def test_the_nearest_person_counts_wherever_anybody_walks(observe: Maker, share: Maker) -> None:
    policy, far = PassiveSafety(obstacle_mps=1.6), (0.0, 3.0, 0.0, 0.0)
    expected = float(safe_speed(1.3 - RADII_M, 1.6)) / 0.5
    for velocity in ((-1.0, 0.0), (1.0, 0.0), (0.0, 0.0)):
        seen = observe((1.3, 0.0, *velocity), far, v=0.5)
        assert share(policy, seen) == pytest.approx(expected, abs=1e-5)
    assert 0.0 < expected < 1.0


def test_faster_obstacles_are_kept_farther_away(observe: Maker) -> None:
    rows = np.stack([observe((x, 0.0, 0.0, 0.0), v=0.5) for x in np.linspace(0.6, 4.0, 20)])
    actions = [PassiveSafety(u).predict(rows)[0] for u in (0.0, 0.8, 1.6, 3.0)]
    assert np.all(np.diff(actions, axis=0) <= 0.0)
    assert np.all(np.diff(actions, axis=1) >= 0.0)
