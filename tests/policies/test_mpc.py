from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, Literal

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
from hazbot_gym.task.step_record import NEARNESS, STEP, rules_of

TRACKS = LAYOUTS["tracks"]
Maker = Callable[..., Any]
Nearness = Literal["depth", "discomfort"]
NEAR, BESIDE = (1.2, 0.0, 0.0, 0.0), (2.0, 1.2, 0.0, 0.0)


def test_weights_are_those_of_the_reward() -> None:
    weights = Config().reward
    assert weights.progress == mpc.PROGRESS
    assert weights.smoothness == -mpc.SMOOTHNESS
    assert weights.contact == -mpc.CONTACT
    assert weights.intrusion == -mpc.INTRUSION[Config().nearness]
    assert Config().nearness == Mpc().nearness


def mirror_image(x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
    """Return a velocity reflected at the line from the origin to (x, y)."""
    angle = 2.0 * np.arctan2(y, x) - np.arctan2(vy, vx)
    speed = np.hypot(vx, vy)
    return float(speed * np.cos(angle)), float(speed * np.sin(angle))


def planned_return(
    levels: tuple[int, ...], measure: Nearness, x: float, y: float, vx: float, vy: float
) -> float:
    """Return the sum of progress, smoothness and intrusion of ``reward_terms`` in a plan.

    Args:
        levels: Speed at the start and after each stage of 0.2 s, in fifths of the nominal speed.
        measure: Of nearness.
        x: Position of a person ahead [m].
        y: To the left [m].
        vx: Velocity of the person [m/s].
        vy: To the left [m/s].
    """
    robot, people = records(ROBOT, 1).view(np.recarray), records(PERSON, 2).view(np.recarray)
    step, terms, found = records(STEP, 1).view(np.recarray), np.zeros(len(TERMS)), 0.0
    walks = (vx, vy), mirror_image(x, y, vx, vy) if levels[0] == 0 else (vx, vy)
    for person, (ux, uy) in zip(people, walks, strict=True):
        person.status, person.radius, person.x, person.y = PRESENT, PERSON_RADIUS_M, x, y
        person.vx, person.vy = ux, uy
    rules, weights = rules_of(Config(nearness=measure)), Config().reward
    for before, after in itertools.pairwise(levels):
        robot[0].v = 0.1 * after
        robot[0].x += 0.1 * (before + after) / 2 * 0.2
        for person in people:
            person.x, person.y = person.x + 0.2 * person.vx, person.y + 0.2 * person.vy
        step[0].progress, step[0].command_change = (before + after) / 10, (after - before) / 5
        reward_terms(robot[0], people, step[0], rules, terms)
        each = weights.progress * terms[0] - mpc.INTRUSION[measure] * terms[1]
        found += each * 2 + weights.smoothness * terms[3]
    return found


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(NEARNESS),
    st.integers(0, 5),
    st.floats(0.2, 2.0),
    st.floats(0.8, 2.0),
    st.floats(-1.4, 0.2),
    st.floats(-0.3, 0.3),
)
def test_its_first_speed_begins_the_plan_that_the_reward_finds_best(
    observe: Maker, share: Maker, measure: Nearness, level: int, x: float, y: float, vx: float,
    vy: float,
) -> None:  # fmt: skip
    plans: dict[int, float] = {}
    for levels in itertools.product(range(6), repeat=3):
        chain = (level, *levels)
        if all(-2 <= after - before <= 1 for before, after in itertools.pairwise(chain)):
            value = planned_return(chain, measure, x, y, vx, vy)
            plans[levels[0]] = max(value, plans.get(levels[0], -np.inf))
    policy = Mpc(caution=1.0, horizon_s=0.6, nearness=measure)
    seen = observe((x, y, vx, vy), v=0.1 * level, command=0.1 * level)
    first = round(5 * share(policy, seen))
    assert plans[first] == pytest.approx(max(plans.values()), abs=1e-3)


@pytest.mark.parametrize(("v", "expected"), [(0.0, 0.2), (0.2, 0.6), (0.4, 1.0), (0.5, 1.0)])
def test_alone_it_gains_speed_level_by_level(
    observe: Maker, share: Maker, v: float, expected: float
) -> None:
    assert share(Mpc(), observe(v=v, command=v)) == pytest.approx(expected)


def test_it_waits_while_somebody_passes_and_drives_on_behind(observe: Maker, share: Maker) -> None:
    policy = Mpc(4.0, nearness="depth")
    seen = (observe((x, 0.9, -1.2, 0.0), v=0.1, command=0.1) for x in (1.0, 0.0, -1.5))
    assert [share(policy, each) for each in seen] == pytest.approx([0.0, 0.0, 0.4])


def test_discomfort_slows_it_beside_somebody_who_passes_and_not_behind(
    observe: Maker, share: Maker
) -> None:
    beside, behind = (
        share(Mpc(), observe((x, 0.9, -1.2, 0.0), v=0.3, command=0.3)) for x in (0.0, -1.5)
    )
    assert beside < 0.6 < behind  # 0.3 m/s is 0.6 of the nominal speed


def test_without_caution_only_contact_slows_it_down(observe: Maker, share: Maker) -> None:
    in_the_way, beside = (0.6, 0.0, 0.0, 0.0), (0.6, 0.6, 0.0, 0.0)
    assert share(Mpc(caution=0.0), observe(beside, v=0.5, command=0.5)) == 1.0
    assert share(Mpc(caution=0.0), observe(in_the_way, v=0.5, command=0.5)) < 1.0


@pytest.mark.parametrize("measure", NEARNESS)
def test_more_caution_is_slower_among_people(observe: Maker, measure: Nearness) -> None:
    rng = np.random.default_rng(2)
    people = rng.uniform([0.5, -1.5, -1.5, -0.5], [4.0, 1.5, 0.5, 0.5], (300, 4))
    rows = np.stack([observe(tuple(person), v=0.4, command=0.4) for person in people])
    policies = [Mpc(caution, nearness=measure) for caution in (1.0, 4.0, 16.0)]
    means = [float(policy.predict(rows)[0].mean()) for policy in policies]
    assert means == sorted(means, reverse=True)
    assert len(set(means)) == 3


@pytest.mark.parametrize(("curvature", "leads_away"), [(0.0, True), (1.0, False), (-1.0, True)])
def test_the_way_ahead_bends_as_the_path_does(
    observe: Maker, share: Maker, curvature: float, leads_away: bool
) -> None:
    seen = observe((0.0, 1.5, 0.0, 0.0), v=0.2, command=0.2)
    column = TRACKS.names.index("curvature_ahead_per_m")
    seen[column] = curvature / TRACKS.fields[column].scale
    assert (share(Mpc(caution=1.5, nearness="depth"), seen) > 0.4) == leads_away


def test_places_on_the_way_lie_on_a_line_or_a_circle() -> None:
    s = np.linspace(0.0, 2.0, 5)
    straight, left, right = mpc.way_ahead(np.array([0.0, 0.5, -0.5]), s)
    np.testing.assert_allclose(straight, [s, np.zeros(5)], atol=1e-8)
    np.testing.assert_allclose(left, [2 * np.sin(s / 2), 2 * (1 - np.cos(s / 2))], atol=1e-12)
    np.testing.assert_allclose(right, left * [[1.0], [-1.0]], atol=1e-12)


def test_plans_for_robots_of_another_nominal_speed(observe: Maker, share: Maker) -> None:
    assert share(Mpc(nominal_mps=0.8), observe(v=0.8, command=0.8)) == 1.0
