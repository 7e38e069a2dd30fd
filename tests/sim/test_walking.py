from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.social_force import (
    ATTENTIVE,
    BLIND,
    CURIOUS,
    WARY,
    Reaction,
    SocialForce,
)
from hazbot_gym.core.state import (
    PATH_PIECE,
    PERSON,
    PRESENT,
    ROBOT,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.sim.walkers import Workspace, make_workspace, put_down, take_up, walk
from hazbot_gym.sim.walking import (
    LOOK_AHEAD_M,
    SIDESTEP_LENGTH_M,
    lane_offset,
    lane_point,
    walking_direction,
)

DT_S = 0.05
CALM = SocialForce(jitter_mps2=0.0)
KEY = np.uint64(5)


def a_place(walls: list[tuple[float, ...]] | None = None) -> Place:
    """Return a route along x, 40 m long, and one straight back."""
    ahead = [[-20.0, 0.0, 0.0], [20.0, 0.0, 40.0]]
    back = [[20.0, 0.0, 0.0], [-20.0, 0.0, 40.0]]
    segments = np.array(walls or []).reshape(-1, 4)
    path = records(PATH_PIECE, 0)
    kinds, anchors = np.zeros(2, np.int64), np.zeros((2, 2))
    return Place(segments, path, np.array([ahead, back]), kinds, anchors, anchors[0])


def walker(x: float, y: float, speed: float = 1.34, *, comes_back: bool = False) -> Records:
    person = records(PERSON, 1)
    person["x"], person["y"], person["vx"] = x, y, -speed if comes_back else speed
    person["radius"], person["desired_speed"], person["status"] = 0.2, speed, PRESENT
    person["model"], person["route"] = SOCIAL_FORCE, int(comes_back)
    person["s"] = 20.0 - x if comes_back else 20.0 + x
    return person.view(np.recarray)


def together(*walkers: Records) -> Records:
    return np.concatenate(walkers).view(np.recarray)


def robot_at(x: float, y: float, v: float = 0.0, theta: float = 0.0) -> Records:
    robots = records(ROBOT, 1)
    robots["x"], robots["y"], robots["v"], robots["theta"] = x, y, v, theta
    return robots.view(np.recarray)[0]


NO_ROBOT = robot_at(0.0, 90.0)


def next_velocities(
    people: Records,
    robot: Records = NO_ROBOT,
    place: Place | None = None,
    force: SocialForce = CALM,
    reaction: Reaction = ATTENTIVE,
) -> Floats:
    place = place or a_place()
    walkers = [i for i in range(len(people)) if people["status"][i] == PRESENT]
    work = Workspace(*(array.view(np.recarray) for array in make_workspace(len(walkers))))
    v = robot.v * math.cos(robot.theta), robot.v * math.sin(robot.theta)
    for w, i in enumerate(walkers):
        take_up(work, w, people, i, place, robot, *v, force, reaction, KEY, 3)
    walk(work, len(walkers), force, DT_S)
    for w, i in enumerate(walkers):
        put_down(work, w, people, i, place, robot, DT_S)
    return np.stack([people["next_vx"], people["next_vy"]], axis=-1)


def stroll(people: Records, robot: Records, seconds: float, **options: Any) -> Floats:
    """Let people walk; return where they were, (steps, people, 2)."""
    places = []
    for _ in range(round(seconds / DT_S)):
        velocities = next_velocities(people, robot, **options)
        people["vx"], people["vy"] = velocities.T
        people["x"] += people["vx"] * DT_S
        people["y"] += people["vy"] * DT_S
        people["s"] += people["vx"] * DT_S * np.where(people["route"] == 0, 1.0, -1.0)
        places.append(np.stack([people["x"], people["y"]], axis=-1))
    return np.array(places)


# --- the way -------------------------------------------------------------------------------------


def test_a_walker_who_steps_aside_changes_its_lane_smoothly() -> None:
    person = walker(0.0, 0.0)[0]
    person.offset, person.sidestep_offset, person.sidestep_s = 0.1, 0.8, 10.0
    s = np.linspace(10.0 - SIDESTEP_LENGTH_M - 1.0, 11.0, 400)
    offsets = np.array([lane_offset(person, value) for value in s])
    assert offsets[0] == pytest.approx(0.1)
    assert offsets[-1] == pytest.approx(0.8)
    assert lane_offset(person, 10.0 - 0.5 * SIDESTEP_LENGTH_M) == pytest.approx(0.45)
    assert np.all(np.diff(offsets) >= 0.0)
    assert np.abs(np.diff(offsets, 2)).max() < 1e-3  # no kink


def test_a_lane_runs_to_the_left_of_its_route_where_the_offset_is_positive() -> None:
    ahead, back = walker(0.0, 0.0)[0], walker(0.0, 0.0, comes_back=True)[0]
    for person in (ahead, back):
        person.offset = person.sidestep_offset = 0.3
    assert lane_point(a_place().routes, ahead, 21.0) == pytest.approx((1.0, 0.3))
    assert lane_point(a_place().routes, back, 21.0) == pytest.approx((-1.0, -0.3))


def test_a_walker_aims_at_its_lane_ahead() -> None:
    ex, ey = walking_direction(walker(0.0, 0.4)[0], a_place().routes)
    assert (ex, ey) == pytest.approx(np.array([LOOK_AHEAD_M, -0.4]) / math.hypot(LOOK_AHEAD_M, 0.4))


# --- the forces ----------------------------------------------------------------------------------


def test_somebody_alone_keeps_walking_at_the_desired_speed() -> None:
    people = walker(0.0, 0.0, 1.1)
    assert next_velocities(people)[0] == pytest.approx((1.1, 0.0))


def test_a_hurried_start_approaches_the_desired_speed_with_the_relaxation_time() -> None:
    people = walker(0.0, 0.0, 1.0)
    people["vx"] = 0.0
    assert next_velocities(people)[0, 0] == pytest.approx(DT_S / CALM.relaxation_time_s)


def test_nobody_walks_faster_than_the_limit() -> None:
    people = walker(0.0, 0.0, 1.0)
    people["vx"] = 9.0
    assert next_velocities(people)[0, 0] == pytest.approx(CALM.speed_limit_ratio)


def test_the_fluctuation_is_a_pure_function_of_key_step_and_person() -> None:
    restless = SocialForce(jitter_mps2=0.5)
    first, again = (next_velocities(walker(0.0, 0.0), force=restless)[0] for _ in range(2))
    pair = next_velocities(together(walker(0.0, 0.0), walker(0.0, 8.0)), force=restless)
    assert first.tolist() == again.tolist() == pair[0].tolist()
    assert pair[0].tolist() != pair[1].tolist()
    assert np.abs(first - (1.34, 0.0)).max() > 1e-3


def test_mirrored_people_do_the_mirrored_thing() -> None:
    walls = [(-9.0, 1.1, 9.0, 1.1)]
    left = together(walker(0.0, 0.2), walker(1.5, 0.35, comes_back=True))
    right = together(walker(0.0, -0.2), walker(1.5, -0.35, comes_back=True))
    up = next_velocities(left, robot_at(1.0, -0.5), a_place(walls))
    down = next_velocities(right, robot_at(1.0, 0.5), a_place([(-9.0, -1.1, 9.0, -1.1)]))
    assert up == pytest.approx(down * (1.0, -1.0))


def test_two_who_meet_head_on_pass_each_other() -> None:
    people = together(walker(-4.0, 0.0), walker(4.0, 0.0, comes_back=True))
    places = stroll(people, NO_ROBOT, 8.0)
    gaps = np.hypot(*(places[:, 0] - places[:, 1]).T) - 0.4
    assert places[-1, 0, 0] > 3.0
    assert places[-1, 1, 0] < -3.0
    assert gaps.min() > 0.0


@pytest.mark.parametrize("speed", [0.2, 0.5, 1.34, 2.0])
def test_a_standing_robot_is_walked_round_at_any_pace(speed: float) -> None:
    people = walker(-4.0, 0.01, speed)
    places = stroll(people, robot_at(0.0, 0.0), 12.0 / speed)
    assert places[-1, 0, 0] > 3.0
    assert np.hypot(*places[:, 0].T).min() > 0.5


def test_somebody_who_has_not_entered_pushes_nobody() -> None:
    people = together(walker(0.0, 0.0), walker(1.0, 0.1, comes_back=True))
    people["status"][1] = WAITING
    assert next_velocities(people)[0] == pytest.approx((1.34, 0.0))


def test_a_blind_person_does_not_respond_to_the_robot() -> None:
    def change(gap_m: float, reaction: Reaction) -> float:
        people = walker(-0.5 - gap_m, 0.1)
        seen = next_velocities(people, robot_at(0.0, 0.0), reaction=reaction)
        return float(np.abs(seen - next_velocities(people, reaction=reaction)).max())

    assert change(0.4, BLIND) == 0.0
    assert change(0.4, ATTENTIVE) > 0.05
    assert change(1.2, ATTENTIVE) < 0.02  # people respond late (docs/encounters.md)


def test_a_wary_person_keeps_farther_away_than_an_attentive_one() -> None:
    def clearance(reaction: Reaction) -> float:
        places = stroll(walker(-4.0, 0.05), robot_at(0.0, 0.0), 6.0, reaction=reaction)
        return float(np.hypot(*places[:, 0].T).min())

    assert clearance(WARY) > clearance(ATTENTIVE) + 0.02


def test_a_curious_person_is_drawn_to_the_robot_but_not_into_it() -> None:
    def change(x: float) -> float:
        people = walker(x, 0.0)
        seen = next_velocities(people, robot_at(0.0, 2.5), reaction=CURIOUS)
        return float((seen - next_velocities(people))[0, 1])

    assert change(0.0) > 0.0
    plain = CURIOUS._replace(attraction_mps2=0.0)
    near = next_velocities(walker(0.0, 0.0), robot_at(1.3, 0.5), reaction=CURIOUS)
    assert near == pytest.approx(
        next_velocities(walker(0.0, 0.0), robot_at(1.3, 0.5), reaction=plain)
    )


# --- burden --------------------------------------------------------------------------------------


def test_a_robot_that_stops_somebody_blocks_it_altogether() -> None:
    people = walker(-0.6, 0.0)
    people["vx"] = 0.0
    next_velocities(people, robot_at(0.0, 0.0))
    assert people["blocked"][0] == 1.0


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (0.0, 1.0), (-4.0, 0.0)])
def test_a_robot_behind_beside_or_far_away_blocks_nobody(x: float, y: float) -> None:
    people = walker(x, y)
    people["vx"], people["offset"], people["sidestep_offset"] = 0.0, y, y
    next_velocities(people, robot_at(0.0, 0.0))
    assert people["blocked"][0] == 0.0


def test_blocking_is_the_share_of_the_desired_speed_that_is_missing() -> None:
    people = walker(-1.5, 0.0)
    people["vx"] = 0.25 * 1.34
    next_velocities(people, robot_at(0.0, 0.0))
    assert people["blocked"][0] == pytest.approx(0.75)


def test_somebody_who_means_to_stand_is_not_blocked() -> None:
    people = walker(-1.0, 0.0, 0.0)
    velocity = next_velocities(people, robot_at(0.0, 0.0))
    assert people["blocked"][0] == 0.0
    assert velocity.tolist() == [[0.0, 0.0]]


def test_people_keep_farther_from_the_robot_than_the_force_among_people_would() -> None:
    def clearance(force: SocialForce) -> float:
        places = stroll(walker(-4.0, 0.05), robot_at(0.0, 0.0), 6.0, force=force)
        return float(np.hypot(*places[:, 0].T).min()) - 0.5  # both radii

    shipped = SocialForce()
    calibrated = shipped._replace(
        robot_strength_mps2=shipped.person_strength_mps2, robot_range_m=shipped.person_range_m
    )
    assert clearance(calibrated) < clearance(shipped) - 0.02
    assert 0.05 < clearance(shipped) < 0.2  # real people come close (docs/encounters.md)
