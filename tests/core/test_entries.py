from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.core.entries import PATIENCE_S, REST_S, pass_on, seat
from hazbot_gym.core.state import (
    GONE,
    PATH_PIECE,
    PERSON,
    WAITING,
    Place,
    Records,
    records,
)


def a_place(times_s: list[float]) -> Place:
    """Return a place where entry i comes in at (i, 0) and leaves at (i, 9)."""
    count = len(times_s)
    routes = np.array([[[i, 0.0, 0.0], [i, 9.0, 9.0]] for i in range(count)])
    kinds, anchors = np.zeros(count, np.int64), np.zeros((count, 2))
    speeds_mps = 1.0 + 0.1 * np.arange(count)
    return Place(
        np.zeros((0, 4)), records(PATH_PIECE, 0), routes, kinds, anchors, anchors[:, 0],
        np.array(times_s), speeds_mps,
    )  # fmt: skip


def seated(place: Place, count: int, start_s: float) -> Records:
    people = records(PERSON, count).view(np.recarray)
    for i in range(count):
        seat(people[i], place, i, start_s)
    return people


def test_a_record_becomes_who_comes_in_next() -> None:
    place = a_place([10.0, 11.0, 12.0, 30.0])
    people = seated(place, 2, start_s=8.0)
    people[0].status, people[0].left_s, people[0].s, people[0].reaction = GONE, 9.0, 9.0, 3
    pass_on(people, 0, place, 9.0 + REST_S)

    assert (people[0].status, people[0].route, people[0].s) == (WAITING, 2, 0.0)
    assert (people[0].x, people[0].y) == (2.0, 0.0)
    assert people[0].enters_s == pytest.approx(4.0)
    assert people[0].desired_speed == pytest.approx(1.2)
    assert people[0].reaction == 3

    people[1].status = GONE
    pass_on(people, 1, place, 60.0)
    assert (people[1].route, people[1].enters_s) == (3, pytest.approx(22.0))


def test_a_record_rests_before_it_is_somebody_else() -> None:
    place = a_place([0.0, 1.0])
    people = seated(place, 1, start_s=0.0)
    people[0].status, people[0].left_s = GONE, 9.0
    pass_on(people, 0, place, 9.0 + 0.9 * REST_S)
    assert people[0].status == GONE


def test_when_all_have_come_records_stay_empty() -> None:
    place = a_place([0.0, 1.0])
    people = seated(place, 2, start_s=0.0)
    people[0].status = GONE
    pass_on(people, 0, place, 60.0)
    assert (people[0].status, people[0].route) == (GONE, 0)


def test_who_finds_no_room_turns_away() -> None:
    place = a_place([3.0, 4.0])
    people = seated(place, 1, start_s=1.0)
    pass_on(people, 0, place, 2.0 + PATIENCE_S)
    assert people[0].status == WAITING
    pass_on(people, 0, place, 2.1 + PATIENCE_S)
    assert people[0].status == GONE
    pass_on(people, 0, place, 2.1 + PATIENCE_S + REST_S)
    assert (people[0].status, people[0].route) == (WAITING, 1)
