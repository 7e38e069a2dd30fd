from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.hooks import NO_HOOK
from hazbot_gym.core.recorded_table import NO_STRETCH, Stretch
from hazbot_gym.core.social_force import ATTENTIVE, BLIND, CURIOUS, WARY, SocialForce
from hazbot_gym.core.state import (
    GONE,
    PATH_PIECE,
    PERSON,
    PRESENT,
    REPLAY,
    ROBOT,
    SCRIPTED,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.sim.people import CATCH_UP_MPS, move_people, social_step
from hazbot_gym.sim.spacing import ROBOT_MARGIN_M
from hazbot_gym.sim.walkers import Workspace, make_workspace
from hazbot_gym.sim.world import World
from hazbot_gym.task.scenario import ScenarioSampler

DT_S = 0.05
KEY = np.uint64(5)
REACTIONS = (ATTENTIVE, BLIND, WARY, CURIOUS)
CALM = SocialForce(jitter_mps2=0.0)


def a_place() -> Place:
    """Return a route along x, 10 m long, without walls."""
    routes = np.array([[[0.0, 0.0, 0.0], [10.0, 0.0, 10.0]]])
    kinds, anchors = np.zeros(1, np.int64), np.zeros((1, 2))
    path = records(PATH_PIECE, 0)
    return Place(np.zeros((0, 4)), path, routes, kinds, anchors, anchors[0])


def person_at(
    x: float, y: float = 0.0, *, model: int = SOCIAL_FORCE, status: int = PRESENT
) -> Records:
    person = records(PERSON, 1)
    person["x"], person["y"], person["s"], person["vx"] = x, y, x, 1.0
    person["offset"] = person["sidestep_offset"] = y
    person["radius"], person["desired_speed"] = 0.2, 1.0
    person["model"], person["status"] = model, status
    return person.view(np.recarray)


def together(*people: Records) -> Records:
    return np.concatenate(people).view(np.recarray)


def robot_at(x: float, y: float) -> Records:
    robots = records(ROBOT, 1)
    robots["x"], robots["y"] = x, y
    return robots.view(np.recarray)[0]


FAR_AWAY = robot_at(0.0, 90.0)


def step_people(people: Records, *arguments: Any) -> None:
    """Take a social step in plain Python."""
    work = Workspace(*(array.view(np.recarray) for array in make_workspace(len(people))))
    social_step(people, *arguments[:4], NO_HOOK, *arguments[4:], DT_S, work)


def walk(
    people: Records,
    steps: int,
    robot: Records = FAR_AWAY,
    recording: Stretch = NO_STRETCH,
) -> Floats:
    """Let people walk; return where they were at every social step, (steps, people, 2)."""
    places = []
    for step in range(steps):
        step_people(people, a_place(), robot, CALM, REACTIONS, recording, KEY, step)
        places.append(np.stack([people["x"], people["y"]], axis=-1))
        move_people(people, DT_S)
    return np.array(places)


# --- coming and going ----------------------------------------------------------------------------


def test_people_enter_at_their_time() -> None:
    person = person_at(0.0, status=WAITING)
    person["enters_s"] = 4 * DT_S
    walk(person, 4)
    assert person["status"][0] == WAITING
    walk(person, 5)
    assert person["status"][0] == PRESENT


def test_reacting_people_wait_until_nobody_stands_where_they_enter() -> None:
    people = together(person_at(0.0, status=WAITING), person_at(0.0))
    places = walk(people, 40)
    entered = int(np.argmax(places[:, 0, 0] > 0.0))
    assert entered > 5
    assert np.abs(places[entered, 0] - places[entered, 1]).max() > 0.45


def test_reacting_people_do_not_enter_into_the_robot_but_scripted_ones_do() -> None:
    people = together(
        person_at(0.0, status=WAITING), person_at(0.0, 1.0, model=SCRIPTED, status=WAITING)
    )
    walk(people, 3, robot_at(0.5, 0.0))
    assert people["status"].tolist() == [WAITING, PRESENT]


@pytest.mark.parametrize("model", [SCRIPTED, SOCIAL_FORCE])
def test_people_are_gone_at_the_end_of_their_route(model: int) -> None:
    person = person_at(9.0, model=model)
    walk(person, 18)
    assert person["status"][0] == PRESENT
    walk(person, 6)
    assert person["status"][0] == GONE
    assert (person["vx"][0], person["vy"][0]) == (0.0, 0.0)


def test_who_is_gone_stays_where_it_was() -> None:
    person = person_at(3.0, status=GONE)
    places = walk(person, 5)
    assert np.all(places == (3.0, 0.0))


# --- choosing ------------------------------------------------------------------------------------


def test_people_choose_at_the_same_time_so_that_their_order_does_not_matter() -> None:
    crowd = [person_at(3.0, 0.1), person_at(3.5, -0.3), person_at(4.1, 0.2)]
    there = walk(together(*crowd), 30)
    back = walk(together(*crowd[::-1]), 30)
    assert there == pytest.approx(back[:, ::-1], abs=1e-12)


def test_compiled_people_walk_like_interpreted_ones() -> None:
    config = make_config(people={"count": [4, 4]})
    scenario = ScenarioSampler(config).draw(11)
    slow, quick = scenario.people.copy(), scenario.people.copy()
    world = World(config)
    world.reset(scenario.place, quick, scenario.recording, 11)
    robot, step = world.robots.copy().view(np.recarray)[0], 0
    place = scenario.place._replace(path=scenario.place.path.view(np.recarray))
    for _ in range(5):
        for _ in range(2):
            step_people(
                slow.view(np.recarray), place, robot, config.people.force,
                config.people.reactions, NO_STRETCH, np.uint64(11), step,
            )  # fmt: skip
            move_people(slow.view(np.recarray), DT_S)
            step += 1
        world.command(0.0)
        world.advance()
    for axis in ("x", "y"):
        assert slow[axis] == pytest.approx(quick[axis], abs=1e-9)


# --- scripted ------------------------------------------------------------------------------------


def test_scripted_people_walk_straight_on_whatever_stands_there() -> None:
    person = person_at(2.0, 0.3, model=SCRIPTED)
    places = walk(person, 21, robot_at(2.6, 0.3))
    assert places[-1, 0] == pytest.approx((3.0, 0.3))


@pytest.mark.parametrize("place", ["corridor", "open"])
@pytest.mark.parametrize("driven_s", [0.0, 3.0, 7.0, 12.0])
def test_a_scripted_head_on_walker_leaves_a_robot_alone_that_stops(
    place: str, driven_s: float
) -> None:
    """Wherever the robot stops on its way: it is never farther than the nominal one would be."""
    config = make_config(
        place=place, people={"model": "scripted", "family": "confronting", "count": [1, 1]}
    )
    source, world = ScenarioSampler(config), World(config)
    for key in range(8):
        scenario = source.draw(key)
        world.reset(scenario.place, scenario.people, scenario.recording, key)
        for decision in range(400):
            world.command(0.5 if decision < driven_s * 10 and world.contact is None else 0.0)
            world.advance()
            if world.contact is not None or world.people["status"][0] == GONE:
                break
        assert world.contact is None
        assert world.people["status"][0] == GONE


# --- replayed ------------------------------------------------------------------------------------


def recorded(*tracks: Floats, firsts: tuple[int, ...] = (0, 0)) -> tuple[Records, Stretch]:
    """Return people who follow tracks that begin at some steps, and the recording."""
    people = records(PERSON, len(tracks)).view(np.recarray)
    people["model"], people["status"], people["radius"] = REPLAY, WAITING, 0.2
    people["route"] = np.arange(len(tracks))
    lengths = np.array([len(track) for track in tracks])
    first_steps = np.array(firsts[: len(tracks)])
    return people, Stretch(
        start=0,
        steps=int((first_steps + lengths).max()),
        slots=np.arange(len(tracks) + 1),
        firsts=first_steps,
        offsets=np.append(0, np.cumsum(lengths)),
        positions=np.concatenate(tracks),
    )


def straight(steps: int, speed: float = 1.0) -> Floats:
    return np.stack([np.arange(steps) * speed * DT_S, np.full(steps, 2.0)], axis=-1)


def test_replayed_people_walk_as_recorded() -> None:
    wobble = straight(40) + np.random.default_rng(0).normal(0.0, 0.01, (40, 2))
    people, recording = recorded(wobble)
    assert walk(people, 39, recording=recording)[:, 0] == pytest.approx(wobble[:39])


def test_replayed_people_are_there_only_while_recorded() -> None:
    people, recording = recorded(straight(30)[5:20], straight(30), firsts=(5, 0))
    present = []
    for step in range(30):
        step_people(people, a_place(), FAR_AWAY, SocialForce(), REACTIONS, recording, KEY, step)
        present.append(int(people["status"][0] == PRESENT))
        move_people(people, DT_S)
    assert present == [0] * 5 + [1] * 14 + [0] * 11
    assert people["status"].tolist() == [GONE, GONE]


def test_replayed_people_walk_round_the_robot_and_return_to_their_track() -> None:
    people, recording = recorded(straight(120))
    robot = robot_at(3.0, 2.05)
    places = walk(people, 119, robot, recording)[:, 0]
    assert np.hypot(*(places - (3.0, 2.05)).T).min() >= 0.5 + ROBOT_MARGIN_M - 1e-9
    assert places[-1] == pytest.approx(recording.positions[118], abs=0.02)
    speeds = np.hypot(*np.diff(places, axis=0).T) / DT_S
    assert speeds.max() <= CATCH_UP_MPS + 1e-9


def test_a_replayed_person_does_not_appear_inside_the_robot() -> None:
    people, recording = recorded(straight(40))
    robot = robot_at(0.0, 2.0)
    for step in range(39):
        step_people(people, a_place(), robot, SocialForce(), REACTIONS, recording, KEY, step)
        if people["status"][0] == PRESENT:
            assert math.hypot(people["x"][0], people["y"][0] - 2.0) >= 0.5
        move_people(people, DT_S)
    assert people["status"][0] == PRESENT
