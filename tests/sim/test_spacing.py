from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.state import (
    PATH_PIECE,
    PERSON,
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    WAITING,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.sim.spacing import ROBOT_MARGIN_M, hold_back, keep_apart, keep_off_robot

DT_S = 0.05
speeds = st.floats(-2.5, 2.5)
places = st.floats(-0.8, 0.8)


def a_place(walls: list[tuple[float, ...]] | None = None) -> Place:
    nothing = np.zeros((1, 2, 3))
    kinds = np.zeros(1, np.int64)
    anchors = np.zeros((1, 2))
    segments = np.array(walls or []).reshape(-1, 4)
    return Place(segments, records(PATH_PIECE, 0), nothing, kinds, anchors, anchors[0])


def people_at(*states: tuple[float, float, float, float]) -> Records:
    """Return people by x, y and the velocity that they are about to take."""
    people = records(PERSON, len(states))
    people["radius"], people["status"] = 0.2, PRESENT
    for field, column in zip(("x", "y", "next_vx", "next_vy"), np.array(states).T, strict=True):
        people[field] = column
    return people.view(np.recarray)


def robot_at(x: float, y: float) -> Records:
    robots = records(ROBOT, 1)
    robots["x"], robots["y"] = x, y
    return robots.view(np.recarray)[0]


def velocity(people: Records, i: int = 0) -> tuple[float, float]:
    return float(people["next_vx"][i]), float(people["next_vy"][i])


def distance(a: Floats, b: Floats) -> float:
    return float(np.hypot(*(a - b)))


def after(people: Records) -> Floats:
    """Return all positions after the step."""
    moved = [people[x] + people[v] * DT_S for x, v in (("x", "next_vx"), ("y", "next_vy"))]
    return np.stack(moved, axis=-1)


FAR_AWAY = robot_at(50.0, 50.0)


def test_a_velocity_below_the_limit_is_left_alone() -> None:
    assert hold_back(0.4, 1.0, 2.0, 0.0, 0.5, True) == (0.4, 1.0)
    assert hold_back(-3.0, 1.0, 2.0, 0.0, 0.0, False) == (-3.0, 1.0)


def test_sliding_takes_away_only_what_leads_into_the_obstacle() -> None:
    assert hold_back(2.0, 1.0, 3.0, 0.0, 0.5, True) == pytest.approx((0.5, 1.0))


def test_slowing_down_keeps_the_direction() -> None:
    assert hold_back(2.0, 1.0, 3.0, 0.0, 0.5, False) == pytest.approx((0.5, 0.25))


def test_an_obstacle_at_the_same_point_holds_nobody_back() -> None:
    assert hold_back(1.0, 1.0, 0.0, 0.0, 0.0, True) == (1.0, 1.0)


@pytest.mark.parametrize("may_slide", [True, False])
@given(vx=speeds, vy=speeds, angle=st.floats(-math.pi, math.pi), limit=st.floats(-1.0, 1.0))
def test_the_limit_holds_along_the_direction_of_the_obstacle(
    may_slide: bool, vx: float, vy: float, angle: float, limit: float
) -> None:
    nx, ny = math.cos(angle), math.sin(angle)
    new_vx, new_vy = hold_back(vx, vy, nx, ny, limit, may_slide)
    assert new_vx * nx + new_vy * ny <= max(limit, 0.0) + 1e-9
    assert math.hypot(new_vx, new_vy) <= math.hypot(vx, vy) + 1e-9


def test_somebody_who_walks_at_the_robot_stops_at_the_margin() -> None:
    touch = ROBOT_RADIUS_M + 0.2
    person = people_at((0.0, 0.0, 1.0, 0.0))[0]
    robot = robot_at(touch + ROBOT_MARGIN_M + 0.01, 0.0)
    vx, vy = keep_off_robot(person, robot, 1.0, 0.0, DT_S, True)
    assert (vx * DT_S, vy) == pytest.approx((0.01, 0.0))


def test_somebody_already_inside_the_margin_may_walk_away() -> None:
    person = people_at((0.0, 0.0, -1.0, 0.0))[0]
    assert keep_off_robot(person, robot_at(0.51, 0.0), -1.0, 0.0, DT_S, True) == (-1.0, 0.0)


def test_nobody_minds_who_has_not_entered_yet() -> None:
    people = people_at((0.0, 0.0, 1.0, 0.0), (0.41, 0.0, 0.0, 0.0))
    people["status"][1] = WAITING
    keep_apart(people, 0, a_place(), FAR_AWAY, DT_S)
    assert velocity(people) == (1.0, 0.0)


def test_a_wall_is_walked_along() -> None:
    people = people_at((0.0, 0.79, 1.0, 1.0))
    keep_apart(people, 0, a_place([(-5.0, 1.0, 5.0, 1.0)]), FAR_AWAY, DT_S)
    assert velocity(people) == pytest.approx((1.0, 0.01 / DT_S))


def test_in_a_corner_between_robot_and_wall_a_person_stops() -> None:
    """Sliding along the wall leads into the robot, and along the robot into the wall."""
    people = people_at((0.0, 0.8, 1.0, 0.4))
    keep_apart(people, 0, a_place([(-5.0, 1.0, 5.0, 1.0)]), robot_at(0.4, 0.45), DT_S)
    x, y = after(people)[0]
    assert math.hypot(x - 0.4, y - 0.45) >= math.hypot(0.4, 0.35) - 1e-9
    assert y <= 0.8 + 1e-9


@given(xs=st.tuples(places, places), ys=st.tuples(places, places), v=st.tuples(*[speeds] * 6))
def test_people_who_do_not_overlap_before_a_step_do_not_after_it(
    xs: tuple[float, ...], ys: tuple[float, ...], v: tuple[float, ...]
) -> None:
    people = people_at(
        (0.0, 0.0, v[0], v[1]), (xs[0], ys[0], v[2], v[3]), (xs[1], ys[1], v[4], v[5])
    )
    before = np.stack([people["x"], people["y"]], axis=-1)
    pairs = [(0, 1), (0, 2), (1, 2)]
    apart = [pair for pair in pairs if distance(*before[list(pair)]) >= 0.4]
    for i in range(3):
        keep_apart(people, i, a_place([(-5.0, 1.1, 5.0, 1.1)]), FAR_AWAY, DT_S)
    for i, j in apart:
        assert distance(*after(people)[[i, j]]) >= 0.4 - 1e-9
    assert after(people)[:, 1].max() <= 0.9 + 1e-9
