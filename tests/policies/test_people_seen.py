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
    """Return (n, 4) x, y, vx, vy of everybody who is there."""
    people = people_seen(TRACKS.decode(observation))
    return np.stack(people[:4], axis=-1)[people.is_there]


def test_where_people_are_and_how_they_walk_is_seen_by_a_driving_and_by_a_standing_robot(
    observe: Maker,
) -> None:
    rng = np.random.default_rng(0)
    for k in range(200):
        person = rng.uniform([-4.0, -4.0, -1.0, -1.0], [4.0, 4.0, 1.0, 1.0])
        found = there(observe(tuple(person), v=0.5 * (k % 2)))
        assert found == pytest.approx(person[None], abs=1e-3)


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
