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
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    WALL,
    Records,
    records,
)
from hazbot_gym.sim.contact import TOP_SPEED_MPS, find_contact, slack, wall_distance

TOUCH_M = ROBOT_RADIUS_M + 0.2
OPEN = np.zeros((0, 4))
AHEAD = np.array([[1.0, -1.0, 1.0, 1.0]])  # a wall across the way at x = 1
DT_S = 0.05

near = st.floats(-2.0, 2.0)
speeds = st.floats(-2.5, 2.5)


def people_at(*states: tuple[float, float, float, float]) -> Records:
    people = records(PERSON, len(states))
    people["radius"], people["status"] = 0.2, PRESENT
    for field, column in zip(("x", "y", "vx", "vy"), np.array(states).T, strict=True):
        people[field] = column
    return people.view(np.recarray)


def robot_at(x: float, y: float = 0.0) -> Records:
    robots = records(ROBOT, 1)
    robots["x"], robots["y"] = x, y
    return robots.view(np.recarray)[0]


NOBODY = records(PERSON, 0).view(np.recarray)


def test_walls_are_as_far_as_their_nearest_point() -> None:
    assert wall_distance(robot_at(0.2), AHEAD) == pytest.approx(0.8)
    assert wall_distance(robot_at(1.0, 1.5), AHEAD) == pytest.approx(0.5)
    assert wall_distance(robot_at(0.0), OPEN) == math.inf


@pytest.mark.parametrize(("x", "contact"), [(TOUCH_M + 1e-9, NO_CONTACT), (TOUCH_M - 1e-9, 0)])
def test_discs_touch_below_the_sum_of_their_radii(x: float, contact: int) -> None:
    assert find_contact(people_at((x, 0.0, 0.0, 0.0)), OPEN, robot_at(0.0), 0.0) == contact


def test_people_are_taken_where_they_are_by_now() -> None:
    people = people_at((1.0, 0.0, -1.0, 0.0))
    assert find_contact(people, OPEN, robot_at(0.0), 0.4) == NO_CONTACT
    assert find_contact(people, OPEN, robot_at(0.0), 0.6) == 0


def test_a_wall_is_touched_below_the_robot_s_radius() -> None:
    assert find_contact(NOBODY, AHEAD, robot_at(0.7 - 1e-9), 0.0) == NO_CONTACT
    assert find_contact(NOBODY, AHEAD, robot_at(0.7 + 1e-9), 0.0) == WALL


def test_people_count_before_walls_and_the_first_before_the_others() -> None:
    people = people_at((5.0, 0.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0), (0.45, 0.0, 0.0, 0.0))
    assert find_contact(people, AHEAD, robot_at(0.8), 0.0) == 1
    people["status"][1] = GONE
    assert find_contact(people, AHEAD, robot_at(0.8), 0.0) == 2


def test_nobody_and_no_wall_is_slack_without_end() -> None:
    assert slack(NOBODY, OPEN, robot_at(0.0), DT_S) == math.inf


@given(x=near, y=near, vx=speeds, vy=speeds, angle=st.floats(0.0, 7.0), share=st.floats(0.0, 1.0))
def test_with_slack_nothing_touches_however_the_robot_drives(
    x: float, y: float, vx: float, vy: float, angle: float, share: float
) -> None:
    people = people_at((x, y, vx, vy))
    if slack(people, AHEAD, robot_at(0.0), DT_S) > 0.0:
        way_m = TOP_SPEED_MPS * DT_S * share
        moved = robot_at(way_m * math.cos(angle), way_m * math.sin(angle))
        assert find_contact(people, AHEAD, moved, DT_S * share) == NO_CONTACT
