from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies.people_seen import RADII_M, clearances_m, of_people, people_seen
from hazbot_gym.task.observation import LAYOUTS, PERSON_SLOTS

TRACKS = LAYOUTS["tracks"]
Maker = Callable[..., Any]


def there(observation: Any) -> Any:
    """Return (n, 4) x, y, vx, vy of everybody who may be there."""
    people = people_seen(TRACKS.decode(observation))
    return np.stack(people[:4], axis=-1)[people.is_there]


def test_a_driving_robot_knows_where_everybody_is_and_walks(observe: Maker) -> None:
    rng = np.random.default_rng(0)
    for _ in range(200):
        x, y, vx, vy = rng.uniform([0.5, 0.3, -1.0, -1.0], [4.0, 2.0, 0.0, -0.2])
        found = there(observe((x, y, vx, vy), v=0.5))
        assert np.abs(found - [x, y, vx, vy]).max(axis=1).min() < 1e-3


def test_the_side_to_which_somebody_walks_follows_from_the_closest_approach(
    observe: Maker,
) -> None:
    beside, into_the_way = (2.0, 1.0, -1.0, 0.0), (2.0, 1.0, -0.6, -0.8)  # mirrored at the sight
    for person in (beside, into_the_way):
        assert there(observe(person, v=0.5)) == pytest.approx(np.array([person]), abs=1e-3)


def test_for_a_standing_robot_somebody_may_walk_to_either_side(observe: Maker) -> None:
    found = there(observe((2.0, 0.0, -0.5, 0.7), v=0.0))
    assert found == pytest.approx(
        np.array([[2.0, 0.0, -0.5, 0.7], [2.0, 0.0, -0.5, -0.7]]), abs=1e-3
    )


def test_nobody_is_seen_in_an_empty_slot(observe: Maker) -> None:
    assert not there(observe(v=0.5)).size
    seen = TRACKS.decode(observe((3.0, 4.0, 0.0, 0.0), v=0.5))
    assert clearances_m(seen).tolist() == [pytest.approx(5.0 - RADII_M), np.inf, np.inf]


def test_stacked_observations_are_told_apart(observe: Maker) -> None:
    rows = [observe((2.0, k, -0.5, 0.3), (3.0, -k, 0.0, 0.0), v=0.4) for k in (0.5, 1.0)]
    seen = TRACKS.decode(np.stack(rows))
    assert of_people(seen, "distance_m").shape == (2, PERSON_SLOTS)
    for k, row in enumerate(rows):
        alone = people_seen(TRACKS.decode(row))
        for together, one in zip(people_seen(seen), alone, strict=True):
            assert np.array_equal(together[k], one)
