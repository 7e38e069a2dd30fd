from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.recorded_table import NO_STRETCH
from hazbot_gym.core.state import (
    GONE,
    PERSON,
    PRESENT,
    ROBOT_RADIUS_M,
    SCRIPTED,
    WALL,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.sim import world as world_module
from hazbot_gym.sim.world import World
from hazbot_gym.task.outcome import BY_PERSON, BY_ROBOT, contact_cause
from hazbot_gym.task.places import load_place
from hazbot_gym.task.scenario import ScenarioSampler

TOUCH_M = ROBOT_RADIUS_M + 0.2
IDEAL = {"wheel_loop": "ideal", "start_speed_mps": 0.5}
EVERYWHERE = ["corridor", "intersection", "doorway", "circle", "aisle", "open"]


def drawn(config: Any, key: int, world: World | None = None) -> World:
    """Return a world at the start of a drawn scenario."""
    world = world or World(config)
    scenario = ScenarioSampler(config).draw(key)
    world.reset(scenario.place, scenario.people, scenario.recording, key)
    return world


def with_walker(x: float, y: float, vx: float, vy: float = 0.0, **drive: Any) -> World:
    """Return a world in the open with one scripted walker."""
    walker = {"x_m": x, "y_m": y, "vx_mps": vx, "vy_mps": vy}
    people = {"model": "scripted", "walkers": [walker]}
    return drawn(make_config(place="open", people=people, drive={**IDEAL, **drive}), 1)


def bodies_of(world: World) -> Floats:
    present = np.flatnonzero(world.people["status"] == PRESENT)
    bodies = [world._robot_body, *(world._person_bodies[i] for i in present)]
    return np.array([body.position for body in bodies])


def records_of(world: World) -> Floats:
    present = world.people[world.people["status"] == PRESENT]
    people = np.stack([present["x"], present["y"]], axis=-1)
    return np.concatenate([np.stack([world.robots["x"], world.robots["y"]], axis=-1), people])


# --- bodies and records --------------------------------------------------------------------------


@pytest.mark.parametrize("place", EVERYWHERE)
def test_bodies_follow_their_records_where_something_is_near(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    near, approach = [], World._advance_near

    def compare(world: World, period: int) -> None:
        present = world.people["status"].tolist()
        approach(world, period)
        # Who comes or goes at the end of a period has a body from the next one on.
        if world.contact is None and world.people["status"].tolist() == present:
            near.append(len(records_of(world)))
            assert bodies_of(world) == pytest.approx(records_of(world), abs=1e-9)

    monkeypatch.setattr(World, "_advance_near", compare)
    config, rng = make_config(place=place, people={"count": [4, 4]}), np.random.default_rng(0)
    for key in range(20):
        world = drawn(config, key)
        for _ in range(250):
            if world.contact is None:
                world.command(float(rng.uniform(0.3, 0.5)))
                world.advance()
    assert near
    assert max(near) > 1  # people, too


def test_a_contact_within_a_social_period_leaves_records_and_bodies_together() -> None:
    world = with_walker(1.013, 0.0, -0.7)
    while world.contact is None:
        world.command(0.5)
        world.advance()
    assert bodies_of(world) == pytest.approx(records_of(world), abs=1e-9)


def test_one_space_serves_all_episodes() -> None:
    config = make_config(people={"count": [1, 4]})
    world = drawn(config, 1)
    space, robot = world._space, world._robot_body
    for key in range(2, 12):
        drawn(config, key, world)
        for _ in range(20):
            world.command(0.5)
            world.advance()
    assert world._space is space
    assert world._robot_body is robot
    assert len(space.bodies) == 1 + len(world._person_bodies) == 1 + 4


def test_an_episode_does_not_depend_on_the_one_before() -> None:
    config = make_config(people={"count": [4, 4]})
    fresh, used = drawn(config, 7), drawn(config, 3)
    for _ in range(60):
        used.command(0.5)
        used.advance()
    drawn(config, 7, used)
    for _ in range(100):
        fresh.command(0.4)
        fresh.advance()
        used.command(0.4)
        used.advance()
        assert fresh.robots.tolist() == used.robots.tolist()
        assert fresh.people.tolist() == used.people.tolist()
        assert (fresh.contact is None) == (used.contact is None)
        if fresh.contact is not None:
            break


def test_another_place_brings_its_own_walls() -> None:
    config = make_config()
    world, nobody = World(config), records(PERSON, 0)
    for name in ("corridor", "open", "aisle", "corridor"):
        place = load_place(name)
        world.reset(place, nobody, NO_STRETCH, 0)
        shapes = [shape for shape in world._space.shapes if shape.collision_type == 3]
        ends = sorted((*shape.a, *shape.b) for shape in shapes)
        assert ends == sorted(map(tuple, place.walls.tolist()))


# --- the shortcut --------------------------------------------------------------------------------


def trajectory(config: Any, key: int, speeds: Floats) -> list[Any]:
    world = drawn(config, key)
    passed = []
    for speed in speeds:
        world.command(float(speed))
        world.advance()
        people = world.people[["x", "y", "vx", "vy", "status"]].tolist()
        passed.append((world.robots.tolist(), people, world.contact))
        if world.contact is not None:
            break
    return passed


@pytest.mark.parametrize("place", EVERYWHERE)
def test_looking_for_contacts_only_where_they_can_occur_changes_nothing(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = make_config(place=place, people={"count": [4, 4]})
    speeds = np.random.default_rng(1).choice([0.0, 0.25, 0.5], 150)
    quick = [trajectory(config, key, speeds) for key in range(4)]
    step = world_module._walk

    def without_slack(*arguments: Any) -> float:
        step(*arguments)
        return -1.0

    monkeypatch.setattr(world_module, "_walk", without_slack)
    assert [trajectory(config, key, speeds) for key in range(4)] == quick


def test_the_shortcut_is_taken_and_contacts_are_met(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without both, the test above would compare a thing with itself."""
    config = make_config(place="doorway", people={"count": [4, 4]})
    taken = []

    def note(usual: Any) -> Any:
        def noting(world: World, *periods: int) -> Any:
            taken.append(usual.__name__)
            return usual(world, *periods)

        return noting

    monkeypatch.setattr(World, "_advance_freely", note(World._advance_freely))
    monkeypatch.setattr(World, "_advance_near", note(World._advance_near))
    ends = [trajectory(config, key, np.full(400, 0.5))[-1][2] for key in range(30)]
    assert set(taken) == {"_advance_freely", "_advance_near"}
    assert any(contact is not None for contact in ends)


# --- contacts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0.0, 0.3, -0.4])
def test_a_person_is_touched_when_the_discs_meet(offset: float) -> None:
    world = with_walker(2.0, offset, -0.5)
    while world.contact is None:
        before = np.hypot(*np.subtract(*records_of(world)))
        world.command(0.5)
        world.advance()
    assert world.contact.person == 0
    assert np.hypot(*np.subtract(*records_of(world))) < TOUCH_M
    assert before >= TOUCH_M
    per_step_m = (0.5 + 0.5) * 0.01
    assert np.hypot(*np.subtract(*records_of(world))) > TOUCH_M - per_step_m - 1e-9


def test_a_person_who_passes_with_a_centimetre_to_spare_is_not_touched() -> None:
    world = with_walker(2.0, TOUCH_M + 0.01, -0.5)
    for _ in range(80):
        world.command(0.5)
        world.advance()
    assert world.contact is None


def test_a_wall_is_touched_when_the_disc_meets_it() -> None:
    world = World(make_config(drive=IDEAL))
    corridor = load_place("open")
    wall = np.array([[2.0, -1.0, 2.0, 1.0]])
    place = Place(wall, *corridor[1:])
    world.reset(place, records(PERSON, 0), NO_STRETCH, 0)
    while world.contact is None:
        world.command(0.5)
        world.advance()
    assert world.contact.person == WALL
    assert world.robots["x"][0] == pytest.approx(2.0 - ROBOT_RADIUS_M, abs=0.5 * 0.01 + 1e-9)
    assert world.robots["x"][0] > 2.0 - ROBOT_RADIUS_M


def test_of_several_contacts_at_once_the_first_person_counts() -> None:
    walkers = [{"x_m": 1.0, "y_m": y, "vx_mps": -0.5, "vy_mps": 0.0} for y in (0.2, -0.2)]
    people = {"model": "scripted", "walkers": walkers}
    world = drawn(make_config(place="open", people=people, drive=IDEAL), 1)
    while world.contact is None:
        world.command(0.5)
        world.advance()
    assert world.contact.person == 0


def test_a_contact_in_the_first_step_is_met_in_every_episode() -> None:
    """pymunk tells only once that two shapes go on touching, even across a reset."""
    world = with_walker(TOUCH_M - 0.01, 0.0, -0.5)
    walker = world.people.copy()
    for _ in range(4):
        world.reset(world.place, walker.copy(), NO_STRETCH, 1)
        world.command(0.5)
        world.advance()
        assert world.contact is not None


def test_the_contact_of_an_episode_is_forgotten_at_the_next() -> None:
    world = with_walker(1.0, 0.0, -0.5)
    walker = world.people.copy()
    walker["x"] = 1.0
    while world.contact is None:
        world.command(0.5)
        world.advance()
    world.reset(world.place, walker, NO_STRETCH, 1)
    assert world.contact is None


def test_people_do_not_push_each_other_in_pymunk() -> None:
    walkers = [{"x_m": x, "y_m": 3.0, "vx_mps": v, "vy_mps": 0.0} for x, v in ((3, 1), (5, -1))]
    people = {"model": "scripted", "walkers": walkers}
    world = drawn(make_config(place="open", people=people, drive=IDEAL), 1)
    for _ in range(20):
        world.command(0.0)
        world.advance()
    assert world.people["x"].tolist() == pytest.approx([5.0, 3.0])


def test_absent_people_touch_nobody() -> None:
    world = with_walker(0.9, 0.0, 0.0)
    absent = world.people.copy()
    absent["model"], absent["status"] = SCRIPTED, GONE
    world.reset(world.place, absent, NO_STRETCH, 1)
    for _ in range(40):
        world.command(0.5)
        world.advance()
    assert world.contact is None


@pytest.mark.parametrize(
    ("person_mps", "command_mps", "cause", "speed_mps"),
    [
        (0.0, 0.5, BY_ROBOT, 0.5),  # drives into somebody who stands
        (-1.0, 0.0, BY_PERSON, 1.0),  # stands, somebody walks into it
        (-0.3, 0.5, BY_ROBOT, 0.8),  # both close in, the robot faster
        (-1.2, 0.5, BY_PERSON, 1.7),  # both close in, the person faster
        (0.2, 0.5, BY_ROBOT, 0.3),  # runs into somebody's back
    ],
)
def test_a_contact_has_a_cause_and_a_speed(
    person_mps: float, command_mps: float, cause: int, speed_mps: float
) -> None:
    world = with_walker(1.5, 0.0, person_mps, start_speed_mps=command_mps)
    while world.contact is None:
        world.command(command_mps)
        world.advance()
    robot, people = world.robots.view(np.recarray)[0], world.people.view(np.recarray)
    assert contact_cause(robot, people[0]) == (cause, pytest.approx(speed_mps, abs=1e-6))


# --- clock and state -----------------------------------------------------------------------------


def test_time_counts_decisions() -> None:
    world = with_walker(9.0, 5.0, 0.0)
    for _ in range(7):
        world.command(0.5)
        world.advance()
    assert world.time_s == 0.7
    assert world.robots["s"][0] == pytest.approx(0.35)


def test_a_snapshot_is_a_copy_of_those_present() -> None:
    world = drawn(make_config(people={"count": [4, 4]}), 2)
    before = world.snapshot()
    copy: Records = before.people.copy()
    assert len(before.people) == np.sum(world.people["status"] == PRESENT)
    for _ in range(5):
        world.command(0.5)
        world.advance()
    assert before.people.tolist() == copy.tolist()
    assert world.snapshot().x > before.x


def test_the_free_time_is_that_of_a_robot_alone_at_full_speed() -> None:
    quiet = {"wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}
    config = make_config(people={"count": [0, 0]}, drive=quiet)
    world = drawn(config, 0)
    goal_m = 12.0 - config.arrival_tolerance_m
    while world.robots["s"][0] + world.robots["x_e"][0] < goal_m:
        world.command(0.5)
        world.advance()
    assert world.free_time_s() == pytest.approx(world.time_s, abs=0.1)
