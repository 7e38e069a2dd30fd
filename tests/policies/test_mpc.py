from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hazbot_gym.config import Config
from hazbot_gym.core.state import PERSON, PERSON_RADIUS_M, PRESENT, ROBOT, records
from hazbot_gym.policies import mpc
from hazbot_gym.policies.mpc import Mpc
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.task.reward import TERMS, reward_terms
from hazbot_gym.task.step_record import STEP, rules_of

TRACKS = LAYOUTS["tracks"]
Maker = Callable[..., Any]
NEAR, BESIDE = (1.2, 0.0, 0.0, 0.0), (2.0, 1.2, 0.0, 0.0)


def test_weights_are_those_of_the_reward() -> None:
    weights = Config().reward
    assert weights.progress == mpc.PROGRESS
    assert weights.smoothness == -mpc.SMOOTHNESS
    assert weights.contact == -mpc.CONTACT


def planned_return(levels: tuple[int, ...], x: float, y: float) -> float:
    """Return the sum of progress, smoothness and intrusion of ``reward_terms`` in a plan.

    Args:
        levels: Speed at the start and after each stage of 0.2 s, in fifths of the nominal speed.
        x: Position of a person ahead [m].
        y: To the left [m].
    """
    robot, people = records(ROBOT, 1).view(np.recarray), records(PERSON, 1).view(np.recarray)
    step, terms, found = records(STEP, 1).view(np.recarray), np.zeros(len(TERMS)), 0.0
    people[0].status, people[0].radius, people[0].x, people[0].y = PRESENT, PERSON_RADIUS_M, x, y
    rules = rules_of(Config())
    for before, after in itertools.pairwise(levels):
        robot[0].v = 0.1 * after
        robot[0].x += 0.1 * (before + after) / 2 * 0.2
        step[0].progress, step[0].command_change = (before + after) / 10, (after - before) / 5
        reward_terms(robot[0], people, step[0], rules, terms)
        weights = Config().reward
        each = weights.progress * terms[0] + weights.intrusion * terms[1]
        found += each * 2 + weights.smoothness * terms[3]
    return found


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 5), st.floats(-0.5, 2.0), st.floats(0.6, 2.0))
def test_its_first_speed_begins_the_plan_that_the_reward_finds_best(
    observe: Maker, share: Maker, level: int, x: float, y: float
) -> None:
    plans: dict[int, float] = {}
    for levels in itertools.product(range(6), repeat=3):
        chain = (level, *levels)
        if all(-2 <= after - before <= 1 for before, after in itertools.pairwise(chain)):
            value = planned_return(chain, x, y)
            plans[levels[0]] = max(value, plans.get(levels[0], -np.inf))
    policy = Mpc(intrusion=-Config().reward.intrusion, horizon_s=0.6)
    first = round(5 * share(policy, observe((x, y, 0.0, 0.0), v=0.1 * level, command=0.1 * level)))
    assert plans[first] == pytest.approx(max(plans.values()), abs=1e-3)


@pytest.mark.parametrize(("v", "expected"), [(0.0, 0.2), (0.2, 0.6), (0.4, 1.0), (0.5, 1.0)])
def test_alone_it_gains_speed_level_by_level(
    observe: Maker, share: Maker, v: float, expected: float
) -> None:
    assert share(Mpc(), observe(v=v, command=v)) == pytest.approx(expected)


def test_it_stands_while_somebody_passes_and_drives_on_behind(observe: Maker, share: Maker) -> None:
    shares = [
        share(Mpc(), observe((x, 0.9, -1.2, 0.0), v=0.1, command=0.1)) for x in (1.0, 0.0, -1.5)
    ]
    assert shares == [0.0, 0.0, pytest.approx(0.4)]


def test_without_a_weight_of_intrusion_only_contact_slows_it_down(
    observe: Maker, share: Maker
) -> None:
    in_the_way, beside = (0.6, 0.0, 0.0, 0.0), (0.6, 0.6, 0.0, 0.0)
    assert share(Mpc(intrusion=0.0), observe(beside, v=0.5, command=0.5)) == 1.0
    assert share(Mpc(intrusion=0.0), observe(in_the_way, v=0.5, command=0.5)) < 1.0


def test_more_weight_of_intrusion_is_slower_among_people(observe: Maker) -> None:
    rng = np.random.default_rng(2)
    people = rng.uniform([0.5, -1.5, -1.5, -0.5], [4.0, 1.5, 0.5, 0.5], (300, 4))
    rows = np.stack([observe(tuple(person), v=0.4, command=0.4) for person in people])
    means = [float(Mpc(intrusion).predict(rows)[0].mean()) for intrusion in (0.0, 1.0, 4.0, 32.0)]
    assert means == sorted(means, reverse=True)
    assert len(set(means)) == 4


@pytest.mark.parametrize(("curvature", "leads_away"), [(0.0, True), (1.0, False), (-1.0, True)])
def test_the_way_ahead_bends_as_the_path_does(
    observe: Maker, share: Maker, curvature: float, leads_away: bool
) -> None:
    seen = observe((0.0, 1.5, 0.0, 0.0), v=0.2, command=0.2)
    column = TRACKS.names.index("curvature_ahead_per_m")
    seen[column] = curvature / TRACKS.fields[column].scale
    assert (share(Mpc(intrusion=6.0), seen) > 0.4) == leads_away


def test_places_on_the_way_lie_on_a_line_or_a_circle() -> None:
    s = np.linspace(0.0, 2.0, 5)
    straight, left, right = mpc.way_ahead(np.array([0.0, 0.5, -0.5]), s)
    np.testing.assert_allclose(straight, [s, np.zeros(5)], atol=1e-8)
    np.testing.assert_allclose(left, [2 * np.sin(s / 2), 2 * (1 - np.cos(s / 2))], atol=1e-12)
    np.testing.assert_allclose(right, left * [[1.0], [-1.0]], atol=1e-12)


def test_plans_for_robots_of_another_nominal_speed(observe: Maker, share: Maker) -> None:
    assert share(Mpc(nominal_mps=0.8), observe(v=0.8, command=0.8)) == 1.0
