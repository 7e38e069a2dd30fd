from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.config import RewardWeights
from hazbot_gym.core.discomfort import discomfort
from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import (
    GONE,
    NO_CONTACT,
    PERSON,
    PRESENT,
    ROBOT,
    WAITING,
    WALL,
    Records,
    as_record,
    records,
)
from hazbot_gym.task.outcome import BY_PERSON, BY_ROBOT
from hazbot_gym.task.reward import (
    SURVEY_TERM,
    TERMS,
    contact_severity,
    intrusion,
    judge_kernel,
    tracking_error,
)
from hazbot_gym.task.step_record import DEPTH, DISCOMFORT, STEP, Rules

PATH = straight_path(np.array([[0.0, 0.0], [12.0, 0.0]]))
RULES = Rules(nominal_speed_mps=0.5, decision_s=0.1, arrival_tolerance_m=0.05, horizon=100)
NUMBERS = st.floats(-20.0, 20.0)


def a_robot(**fields: float) -> Records:
    robots = records(ROBOT, 1)
    for name, value in {"v": 0.5, **fields}.items():
        robots[name] = value
    return robots


def somebody(clearance_m: float, **fields: float) -> Records:
    people = records(PERSON, 1)
    for name, value in {"radius": 0.2, "status": PRESENT, **fields}.items():
        people[name] = value
    people["x"] = clearance_m + 0.3 + people["radius"]
    return people


def judged(
    robot: Records | None = None,
    people: Records | None = None,
    *,
    contact: int = NO_CONTACT,
    steps: int = 50,
    progress: float = 0.0,
    command_change: float = 0.0,
    nearness: int = DEPTH,
) -> dict[str, float]:
    record, out = records(STEP, 1), np.full(len(TERMS), np.nan)
    robot = a_robot() if robot is None else robot
    people = records(PERSON, 0) if people is None else people
    record["s_before_m"] = robot["s"] - 0.05 * progress
    record["command_before_mps"] = robot["command"] - 0.5 * command_change
    rules = as_record(RULES._replace(nearness=nearness))
    judge_kernel(record, robot, people, PATH, contact, steps, rules, out)
    return dict(zip(TERMS, out.tolist(), strict=True))


@given(
    st.lists(NUMBERS, min_size=5, max_size=5),
    st.tuples(NUMBERS, NUMBERS, NUMBERS, st.floats(0.0, 1.0)),
    st.tuples(NUMBERS, NUMBERS),
    st.sampled_from([NO_CONTACT, WALL, 0]),
    st.integers(1, 100),
    st.sampled_from([DEPTH, DISCOMFORT]),
)
def test_every_term_is_within_its_range_whatever_happens(
    state: list[float],
    person: tuple[float, float, float, float],
    decision: tuple[float, float],
    contact: int,
    steps: int,
    nearness: int,
) -> None:
    robot = a_robot(**dict(zip(("v", "s", "x_e", "y_e", "theta_e"), state, strict=True)))
    x, vx, vy, blocked = person
    people = somebody(x, vx=vx, vy=vy, blocked=blocked)
    terms = judged(
        robot,
        people,
        contact=contact,
        steps=steps,
        progress=decision[0],
        command_change=decision[1],
        nearness=nearness,
    )

    assert (*terms, SURVEY_TERM) == RewardWeights._fields
    assert 0.0 <= terms.pop("arrival") <= RULES.horizon * RULES.decision_s
    assert all(0.0 <= value <= 1.0 for value in terms.values())  # one person at most


@pytest.mark.parametrize(("progress", "expected"), [(-0.2, 0.0), (0.4, 0.4), (1.3, 1.0)])
def test_progress_is_relative_to_nominal_speed(progress: float, expected: float) -> None:
    assert judged(progress=progress)["progress"] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("clearance_m", "v", "expected"),
    [
        (0.825, 0.5, 0.5),
        (0.825, 0.25, 0.25),
        (0.825, -0.25, 0.25),  # backing off is driving too
        (0.825, 0.0, 0.0),  # waiting beside somebody is free
        (0.2, 0.6, 1.0),
        (1.3, 0.5, 0.0),
    ],
)
def test_intrusion_takes_nearness_and_the_robots_own_speed(
    clearance_m: float, v: float, expected: float
) -> None:
    terms = judged(a_robot(v=v), somebody(clearance_m))

    assert terms["intrusion"] == pytest.approx(expected)
    robot, people = a_robot(v=v).view(np.recarray)[0], somebody(clearance_m).view(np.recarray)
    assert intrusion(robot, people, RULES) == pytest.approx(expected)


def test_nearest_of_several_people_counts() -> None:
    people = np.concatenate([somebody(1.0), somebody(0.5), somebody(2.0)])

    assert judged(people=people)["intrusion"] == pytest.approx((1.2 - 0.5) / 0.75)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
def test_discomfort_is_charged_with_the_square_of_the_speed(share: float) -> None:
    terms = judged(a_robot(v=0.5 * share), somebody(0.45, vx=-1.0), nearness=DISCOMFORT)
    assert terms["intrusion"] == pytest.approx(share**2 * discomfort(0.45, 1.0))


def test_largest_discomfort_of_several_people_counts() -> None:
    leaving, coming = somebody(0.6, vx=1.0), somebody(0.9, vx=-1.0)
    terms = judged(people=np.concatenate([leaving, coming]), nearness=DISCOMFORT)
    assert terms["intrusion"] == pytest.approx(discomfort(0.9, 1.0))
    assert discomfort(0.9, 1.0) > discomfort(0.6, -1.0)


@pytest.mark.parametrize("status", [WAITING, GONE])
def test_who_is_not_there_is_neither_intruded_upon_nor_burdened(status: int) -> None:
    terms = judged(people=somebody(0.1, status=status, blocked=1.0))

    assert (terms["intrusion"], terms["burden"]) == (0.0, 0.0)


def test_burden_is_the_sum_of_what_people_lose() -> None:
    people = np.concatenate([somebody(2.0, blocked=0.3), somebody(3.0, blocked=0.7)])

    assert judged(people=people)["burden"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("y_e", "theta_e", "expected"),
    [(0.0, 0.0, 0.0), (0.15, 0.0, 0.25), (0.0, -0.25, 0.25), (-0.15, 0.25, 0.5), (0.3, 0.5, 1.0)],
)
def test_tracking_term_grows_with_the_square_of_the_errors(
    y_e: float, theta_e: float, expected: float
) -> None:
    robot = a_robot(y_e=y_e, theta_e=theta_e)

    assert judged(robot)["tracking"] == pytest.approx(expected)
    assert tracking_error(robot.view(np.recarray)[0]) == pytest.approx(expected)


def test_one_large_change_of_speed_costs_more_than_two_small_ones() -> None:
    whole, half = (judged(command_change=change)["smoothness"] for change in (-1.0, 0.5))

    assert whole == 1.0
    assert 2.0 * half == pytest.approx(0.5)


def test_arrival_is_worth_the_time_that_is_left_in_seconds() -> None:
    arrived = a_robot(s=12.0)

    assert judged(arrived, steps=25)["arrival"] == pytest.approx(7.5)
    assert judged(arrived, steps=100)["arrival"] == 0.0
    assert judged(steps=25)["arrival"] == 0.0


def test_contact_is_judged_by_its_speed_and_who_caused_it() -> None:
    assert contact_severity(BY_ROBOT, 0.0) == 0.5
    assert contact_severity(BY_ROBOT, 0.75) == pytest.approx(0.75)
    assert contact_severity(BY_ROBOT, 9.0) == 1.0
    assert contact_severity(BY_PERSON, 9.0) == pytest.approx(0.2)

    into_wall = judged(a_robot(v=0.5, s=12.0), contact=WALL, steps=1)
    assert into_wall["contact"] == pytest.approx(2.0 / 3.0)
    assert into_wall["arrival"] == 0.0
    run_into = judged(people=somebody(0.0, vx=-1.0), contact=0)
    assert run_into["contact"] == pytest.approx(0.2)


def a_stroll(commands: list[float]) -> float:
    """Return the default reward of driving alone at these shares of the nominal speed."""
    weights: dict[str, Any] = RewardWeights()._asdict()
    changes = np.diff([0.0, *commands])
    steps = [judged(progress=c, command_change=d) for c, d in zip(commands, changes, strict=True)]
    return math.fsum(weights[name] * value for terms in steps for name, value in terms.items())


def test_steady_speed_is_worth_more_than_on_and_off_at_the_same_mean() -> None:
    assert a_stroll([0.5] * 20) > a_stroll([1.0, 0.0] * 10)


def test_a_second_in_intimate_space_at_nominal_speed_costs_more_than_a_second_of_delay() -> None:
    weights = RewardWeights()
    beside = judged(a_robot(v=0.5), somebody(0.3), nearness=DISCOMFORT)["intrusion"]
    slowly = judged(a_robot(v=0.25), somebody(0.3), nearness=DISCOMFORT)["intrusion"]

    assert weights.intrusion * beside / RULES.decision_s < -weights.arrival
    assert weights.intrusion * slowly / RULES.decision_s > -weights.arrival  # so speed matters


def test_a_person_pays_as_much_for_delay_as_the_robot() -> None:
    weights = RewardWeights()
    stopped = judged(people=somebody(2.0, blocked=1.0))["burden"]
    assert weights.burden * stopped / RULES.decision_s == pytest.approx(-weights.arrival)
