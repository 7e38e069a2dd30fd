from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import NO_CONTACT, PERSON, ROBOT, WALL, records
from hazbot_gym.task.outcome import (
    ARRIVED,
    BY_PERSON,
    BY_ROBOT,
    CONTACT_PERSON,
    CONTACT_WALL,
    NOBODY,
    RUNNING,
    TIMEOUT,
    contact_cause,
    terminate,
)
from hazbot_gym.task.step_record import STEP, Rules

PATH = straight_path(np.array([[0.0, 0.0], [12.0, 0.0]])).view(np.recarray)
RULES = Rules(nominal_speed_mps=0.5, decision_s=0.1, arrival_tolerance_m=0.05, horizon=600)


def record(dtype: np.dtype[np.void], **fields: float) -> Any:
    one = records(dtype, 1).view(np.recarray)[0]
    for name, value in fields.items():
        one[name] = value
    return one


def settled(*, contact: int = NO_CONTACT, steps: int = 100, **robot: float) -> Any:
    decision = record(STEP)
    people = records(PERSON, 2).view(np.recarray)
    people["x"], people["vx"] = (9.0, 0.5), (0.0, -1.0)
    terminate(decision, record(ROBOT, **robot), people, PATH, contact, steps, RULES)
    return decision


@pytest.mark.parametrize(
    ("theta", "v", "person", "cause", "speed_mps"),
    [
        (0.0, 0.5, (0.5, 0.0, 0.0, 0.0), BY_ROBOT, 0.5),  # drives into somebody who stands
        (0.0, 0.5, (0.5, 0.0, -0.4, 0.0), BY_ROBOT, 0.9),
        (0.0, 0.5, (0.5, 0.0, -0.6, 0.0), BY_PERSON, 1.1),  # head-on, the person faster
        (0.0, 0.5, (0.5, 0.0, 0.3, 0.0), BY_ROBOT, 0.2),  # runs up from behind
        (0.0, 0.5, (-0.5, 0.0, 1.3, 0.0), BY_PERSON, 0.8),  # is run up to
        (0.0, 0.04, (0.5, 0.0, 0.0, 0.0), BY_PERSON, 0.04),  # as good as standing
        (0.0, 0.0, (0.5, 0.0, -1.0, 0.0), BY_PERSON, 1.0),
        (0.0, -0.5, (-0.5, 0.0, 0.0, 0.0), BY_ROBOT, 0.5),  # backwards
        (0.0, 0.5, (0.0, 0.5, 0.0, -1.0), BY_PERSON, math.hypot(0.5, 1.0)),  # from the side
        (math.pi / 2, 0.5, (0.0, 0.5, 0.3, 0.0), BY_ROBOT, math.hypot(0.5, 0.3)),
        (0.0, 0.5, (0.5, 0.0, -0.505, 0.0), BY_ROBOT, 1.005),  # alike, to within 0.01 m/s
        (0.0, 0.5, (0.5, 0.0, -0.515, 0.0), BY_PERSON, 1.015),
        (0.0, 0.5, (0.0, 0.0, 0.0, 0.0), BY_ROBOT, 0.5),  # on one spot
    ],
)
def test_contact_is_caused_by_the_robot_if_it_moves_and_closes_no_slower(
    theta: float, v: float, person: tuple[float, ...], cause: int, speed_mps: float
) -> None:
    x, y, vx, vy = person
    robot = record(ROBOT, theta=theta, v=v)

    result = contact_cause(robot, record(PERSON, x=x, y=y, vx=vx, vy=vy))

    assert result == (cause, pytest.approx(speed_mps))


def test_decision_on_the_way_leaves_the_episode_running() -> None:
    decision = settled(s=5.0, v=0.5)

    assert (decision.outcome, decision.cause, decision.contact_speed_mps) == (RUNNING, NOBODY, 0.0)
    assert decision.time_left_s == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("s", "x_e", "outcome"),
    [
        (11.96, 0.0, ARRIVED),
        (11.94, 0.0, RUNNING),
        (12.0, -0.1, RUNNING),  # the robot is behind its reference
        (11.9, 0.06, ARRIVED),
    ],
)
def test_arrival_is_where_the_robot_is_and_not_its_reference(
    s: float, x_e: float, outcome: int
) -> None:
    assert settled(s=s, x_e=x_e).outcome == outcome


def test_time_runs_out_at_the_horizon() -> None:
    assert settled(s=5.0, steps=599).outcome == RUNNING
    assert settled(s=5.0, steps=600).outcome == TIMEOUT
    assert settled(s=12.0, steps=600).outcome == ARRIVED
    assert settled(s=12.0, steps=600).time_left_s == 0.0


def test_contact_names_its_cause_and_speed_and_comes_before_arrival() -> None:
    person = settled(contact=1, s=12.0, v=0.5)
    wall = settled(contact=WALL, s=12.0, v=-0.5)

    assert (person.outcome, person.cause) == (CONTACT_PERSON, BY_PERSON)
    assert person.contact_speed_mps == 1.5
    assert (wall.outcome, wall.cause, wall.contact_speed_mps) == (CONTACT_WALL, BY_ROBOT, 0.5)
    assert settled(contact=0, v=0.5).cause == BY_ROBOT  # whom it drives into stands
