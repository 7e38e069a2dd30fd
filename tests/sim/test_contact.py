from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.state import (
    GONE,
    NO_CONTACT,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    TOP_SPEED_MPS,
    WAITING,
    WALL,
    Floats,
    Records,
    records,
)
from hazbot_gym.sim.contact import ENOUGH_M, find_contact, slack, wall_distance

TOUCH_M = ROBOT_RADIUS_M + PERSON_RADIUS_M
NO_WALLS = np.zeros((0, 4))
PERIOD_S = 0.05
metres = st.floats(-2.0, 2.0)
speeds = st.floats(-2.0, 2.0)


def a_robot(x: float = 0.0, y: float = 0.0) -> np.recarray:
    robots = records(ROBOT, 1).view(np.recarray)
    robots[0].x, robots[0].y = x, y
    return robots[0]


def somebody(*rows: tuple[float, float, float, float]) -> Records:
    """Return people present at x, y with velocity vx, vy."""
    people = records(PERSON, len(rows)).view(np.recarray)
    for person, row in zip(people, rows, strict=True):
        person.x, person.y, person.vx, person.vy = row
        person.radius, person.status = PERSON_RADIUS_M, PRESENT
    return people


def a_wall(x1: float, y1: float, x2: float, y2: float) -> Floats:
    return np.array([[x1, y1, x2, y2]])


@pytest.mark.parametrize(
    ("wall", "distance"),
    [
        (a_wall(-1.0, 0.5, 1.0, 0.5), 0.5),  # beside it
        (a_wall(3.0, 4.0, 6.0, 8.0), 5.0),  # nearest at an end
        (a_wall(0.3, 0.4, 0.3, 0.4), 0.5),  # a post
        (a_wall(9.0, 9.0, 12.0, 9.0), 8.0),  # farther than anybody asks
        (NO_WALLS, 8.0),
    ],
)
def test_the_distance_of_a_wall_is_that_of_its_nearest_point(wall: Floats, distance: float) -> None:
    assert wall_distance(a_robot(), wall, within_m=8.0) == pytest.approx(distance)


@pytest.mark.parametrize(("gap", "contact"), [(-1e-9, 0), (1e-9, NO_CONTACT)])
def test_a_person_is_touched_where_the_discs_overlap(gap: float, contact: int) -> None:
    people = somebody(((TOUCH_M + gap) * 0.6, (TOUCH_M + gap) * 0.8, 0.0, 0.0))
    assert find_contact(people, NO_WALLS, a_robot(), 0.0) == contact


@pytest.mark.parametrize(("gap", "contact"), [(-1e-9, WALL), (1e-9, NO_CONTACT)])
def test_a_wall_is_touched_within_the_robots_radius(gap: float, contact: int) -> None:
    wall = a_wall(-5.0, ROBOT_RADIUS_M + gap, 5.0, ROBOT_RADIUS_M + gap)
    assert find_contact(somebody(), wall, a_robot(), 0.0) == contact


def test_a_person_walks_on_between_social_steps() -> None:
    people = somebody((0.6, 0.0, -1.0, 0.0))
    touched = [find_contact(people, NO_WALLS, a_robot(), t) for t in (0.0, 0.09, 0.11)]
    assert touched == [NO_CONTACT, NO_CONTACT, 0]


def test_of_several_contacts_the_first_person_counts_and_people_before_walls() -> None:
    people = somebody((5.0, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0), (0.0, 0.1, 0.0, 0.0))
    assert find_contact(people, a_wall(-1.0, 0.0, 1.0, 0.0), a_robot(), 0.0) == 1


@pytest.mark.parametrize("status", [WAITING, GONE])
def test_people_who_are_not_there_are_not_touched(status: int) -> None:
    people = somebody((0.0, 0.0, 0.0, 0.0))
    people[0].status = status
    assert find_contact(people, NO_WALLS, a_robot(), 0.0) == NO_CONTACT
    assert slack(people, NO_WALLS, a_robot(), PERIOD_S) == pytest.approx(ENOUGH_M)


def test_the_slack_is_what_is_left_after_both_have_moved() -> None:
    people = somebody((1.5, 0.0, 0.6, 0.8))
    left = 1.5 - TOUCH_M - PERIOD_S * (1.0 + TOP_SPEED_MPS)
    assert slack(people, NO_WALLS, a_robot(), PERIOD_S) == pytest.approx(left)
    near = a_wall(1.0, -9.0, 1.0, 9.0)
    left = 1.0 - ROBOT_RADIUS_M - PERIOD_S * TOP_SPEED_MPS
    assert slack(people, near, a_robot(), PERIOD_S) == pytest.approx(left)


@given(metres, metres, speeds, speeds, metres, st.floats(-math.pi, math.pi), st.floats(0.0, 1.0))
def test_nothing_is_touched_while_there_is_slack(
    x: float, y: float, vx: float, vy: float, wall_x: float, heading: float, share: float
) -> None:
    people, wall = somebody((x, y, vx, vy)), a_wall(wall_x, -1.0, wall_x, 1.0)
    if slack(people, wall, a_robot(), PERIOD_S) > 0.0:
        elapsed_s = share * PERIOD_S
        way = elapsed_s * TOP_SPEED_MPS
        robot = a_robot(way * math.cos(heading), way * math.sin(heading))
        assert find_contact(people, wall, robot, elapsed_s) == NO_CONTACT
