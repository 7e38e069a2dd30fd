"""One world of the batched engine as plain Python; the parity test runs it compiled and whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import NO_CONTACT, PRESENT, WALL, Records, records
from hazbot_gym.sim.batched_worlds import (
    GROUP,
    Surroundings,
    Worlds,
    advance_group,
    allocate,
    mechanics,
    start_people,
)
from hazbot_gym.sim.drive import place_robot
from hazbot_gym.sim.walkers import Workspace, make_workspace
from hazbot_gym.sim.world import World
from hazbot_gym.task.scenario import ScenarioSampler

QUIET = {"wheel_noise_radps": 0.0, "heading_noise_rad": 0.0}


def readable(value: Any) -> Any:
    """Return records whose fields are attributes, as they are in compiled code."""
    if isinstance(value, np.ndarray) and value.dtype.names:
        return value.view(np.recarray)
    return value


class Alone:
    """The first of two worlds, stepped by the batched engine's formulas; the other stands still."""

    def __init__(self, config: Config, key: int) -> None:
        source = ScenarioSampler(config)
        scenario = source.draw(key)
        self.place, m = scenario.place, mechanics(config)
        self.mechanics = type(m)(*map(readable, m))
        places = source.table.places._replace(paths=readable(source.table.places.paths))
        self.surroundings = Surroundings(places, source.table.recorded)
        worlds = allocate(
            2, len(scenario.people), len(config.sensors.ring), tracker_latency=0,
            drive_latency=0, has_gas=False,
        )  # fmt: skip
        self.worlds = Worlds(*map(readable, worlds))
        self.worlds.people[0] = scenario.people
        self.worlds.keys[0] = key
        self.group = readable(records(GROUP, 1))[0]
        self.work = Workspace(*map(readable, make_workspace(2 * len(scenario.people))))
        path, speed_mps = readable(self.place.path), config.drive.start_speed_mps
        m, worlds = self.mechanics, self.worlds
        place_robot(worlds.robots[0], worlds.wheels[0], path, speed_mps, m.drive[0], m.gains)
        start_people(worlds, 0, self.surroundings, m, self.work)
        self.robots, self.people = worlds.robots[:1], worlds.people[0]

    def step(self, command_mps: float) -> int:
        self.robots[0].command = self.robots[0].obeyed = command_mps
        self.group.world[0] = 0
        advance_group(self.group, 1, self.worlds, self.surroundings, self.mechanics, self.work)
        self.worlds.steps[0] += 1
        return int(self.group.contact[0])


def both(config: Config, key: int) -> tuple[Alone, World]:
    """Return the same world in both engines."""
    scenario, world = ScenarioSampler(config).draw(key), World(config)
    world.reset(scenario.place, scenario.people, scenario.recording, key)
    return Alone(config, key), world


def assert_alike(one: Records, other: Records) -> None:
    assert one.dtype.names is not None
    for name in one.dtype.names:
        assert one[name] == pytest.approx(other[name], abs=1e-12, nan_ok=True)


@pytest.mark.parametrize("wheel_loop", ["fuzzy_pid", "pid", "ideal"])
def test_a_decision_is_that_of_the_reference_engine(wheel_loop: str) -> None:
    config = make_config(
        people={"model": "scripted", "count": [2, 2]}, drive={"wheel_loop": wheel_loop, **QUIET}
    )
    alone, world = both(config, 3)
    for speed_mps in (0.5, 0.5, 0.1, 0.4):
        assert alone.step(speed_mps) == NO_CONTACT
        world.command(speed_mps)
        world.advance()
        assert_alike(alone.robots, world.robots)
        assert_alike(alone.people, world.people)


def facing(x_m: float) -> Config:
    """Return a problem in which one walker comes straight at a robot already rolling."""
    walker = {"x_m": x_m, "y_m": 0.0, "vx_mps": -0.7, "vy_mps": 0.0}
    drive = {"wheel_loop": "ideal", "start_speed_mps": 0.5, **QUIET}
    return make_config(place="open", people={"model": "scripted", "walkers": [walker]}, drive=drive)


def test_time_stands_still_at_a_contact_within_a_decision() -> None:
    alone, world = both(facing(0.57), 1)  # 0.07 m apart, closing at 1.2 m/s: after 0.06 s
    world.command(0.5)
    world.advance()
    assert alone.step(0.5) == world.contact.person == 0
    assert alone.robots[0].x == pytest.approx(0.06 * 0.5)
    assert alone.people[0].x == pytest.approx(0.57 - 0.06 * 0.7)
    assert_alike(alone.robots, world.robots)
    assert_alike(alone.people, world.people)


def test_a_wall_is_told_from_a_person() -> None:
    config = make_config(people={"count": [0, 0]}, drive={"wheel_loop": "ideal", **QUIET})
    alone = Alone(config, 1)
    alone.robots[0].y = alone.place.walls[:, 1].max() - 0.2
    assert alone.step(0.5) == WALL


def test_the_error_at_the_end_of_a_decision_is_the_true_one() -> None:
    alone = Alone(make_config(people={"count": [0, 0]}, drive=QUIET), 1)
    for _ in range(4):
        alone.step(0.5)
    robot = alone.robots[0]  # on a straight path along x
    along, across = robot.x - robot.s, robot.y
    cos, sin = np.cos(robot.theta), np.sin(robot.theta)
    assert robot.x_e == pytest.approx(cos * along + sin * across, abs=1e-12)
    assert robot.y_e == pytest.approx(-sin * along + cos * across, abs=1e-12)


def test_worlds_are_arrays_of_a_row_each() -> None:
    worlds = allocate(7, 3, 4, tracker_latency=2, drive_latency=4, has_gas=True)
    assert {array.shape[0] for array in worlds} == {7}
    assert worlds.wheels.shape == (7, 2)
    assert worlds.ranges.shape == (7, 4)
    assert worlds.people.shape == worlds.tracks.shape == (7, 3)
    assert worlds.history.shape == (7, 3, 3)
    assert not (worlds.people["status"] == PRESENT).any()


def test_mechanics_hold_the_configs_constants() -> None:
    config = make_config(
        drive={"plant": {"T1": 1.5}, "tracking": {"a1": -2.0}},
        people={"force": {"jitter_mps2": 0.4}},
        clock={"physics_s": 0.005, "social_s": 0.1, "decision_s": 0.2},
    )
    m = mechanics(config)
    assert m.drive["plant"]["T1"][0] == 1.5
    assert m.drive["tracking"]["a1"][0] == -2.0
    assert m.drive["dt_s"][0] == m.physics_s == 0.005
    assert m.force["jitter_mps2"][0] == 0.4
    assert m.reactions["range_m"].tolist() == [3.0, 0.0, 6.0, 4.0]
    assert (m.physics_per_social, m.social_per_decision) == (20, 2)
