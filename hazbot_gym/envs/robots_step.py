"""Step kernel of several robots in one place (``envs/robots.py``).

Each robot has a world of the batched engine, with a path, sensors and noise of its own. The first
records of people are the same in all worlds; the others are the robots as bodies, its own absent.
After each social period the worlds are made alike again: a person is taken from the world of the
nearest robot. So it reacts to that robot by its reaction, and to others as to a person of their
size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import (
    GONE,
    NO_CONTACT,
    PRESENT,
    Floats,
    Ints,
    PersonRecord,
    Records,
    RobotRecord,
)
from hazbot_gym.envs.batch_step import (
    Bools,
    Outputs,
    Problem,
    command_world,
    judge_world,
    observe_world,
    perceive_world,
    surroundings_of,
)
from hazbot_gym.sim.batched_worlds import Worlds, advance_group, place_of, start_people
from hazbot_gym.sim.drive import place_robot
from hazbot_gym.sim.walkers import Workspace


class Robots(NamedTuple):
    """State of the robots besides that of their worlds."""

    people: int  # number of records before those of the robots
    present: Bools  # (R,) True while the robot's episode is running
    contacts: Ints  # (R,) index of the touched record, WALL or NO_CONTACT in this decision


@scalar
def _is_moving(robots: Robots, i: int) -> bool:
    """Return True if robot i is in the place, and its world is not frozen by a contact."""
    return bool(robots.present[i]) and robots.contacts[i] == NO_CONTACT


@scalar
def _nearest_robot(person: int, worlds: Worlds, robots: Robots) -> int:
    """Return the moving robot nearest to a person, -1 without one."""
    nearest, least_m = -1, np.inf
    for i in range(worlds.robots.shape[0]):
        me, robot = worlds.people[i, person], worlds.robots[i]
        distance_m = norm(robot.x - me.x, robot.y - me.y)
        if _is_moving(robots, i) and distance_m < least_m:
            nearest, least_m = i, distance_m
    return nearest


@scalar
def _write_body(body: PersonRecord, robot: RobotRecord, is_there: bool) -> None:
    """Write a robot's pose and velocity into the record by which others perceive it."""
    sine, cosine = sin_cos(robot.theta)
    body.status = PRESENT if is_there else GONE
    body.x, body.y = robot.x, robot.y
    body.vx, body.vy = robot.v * cosine, robot.v * sine


@scalar
def _share(worlds: Worlds, robots: Robots) -> None:
    """Make the people alike in all moving worlds, and show each robot the others."""
    count = worlds.robots.shape[0]
    for k in range(robots.people):
        nearest = _nearest_robot(k, worlds, robots)
        for i in range(count):
            if i != nearest and _is_moving(robots, i):
                blocked = worlds.people[i, k].blocked  # by robot i
                worlds.people[i, k] = worlds.people[nearest, k]
                worlds.people[i, k].blocked = blocked
    for i in range(count):
        if _is_moving(robots, i):
            for j in range(count):
                is_there = bool(robots.present[j]) and j != i
                _write_body(worlds.people[i, robots.people + j], worlds.robots[j], is_there)


@scalar
def _advance_period(
    worlds: Worlds, robots: Robots, problem: Problem, group: Records, work: Workspace
) -> None:
    """Drive and walk for a social period; both robots of a contact stop there."""
    lanes, count = group[0], 0
    for i in range(worlds.robots.shape[0]):
        if _is_moving(robots, i):
            lanes.world[count] = i
            count += 1
    advance_group(lanes, count, worlds, surroundings_of(problem), problem.mechanics, work)
    for lane in range(count):
        robots.contacts[lanes.world[lane]] = lanes.contact[lane]
    for i in range(worlds.robots.shape[0]):
        other = robots.contacts[i] - robots.people
        if other >= 0 and robots.contacts[other] == NO_CONTACT:
            robots.contacts[other] = robots.people + i
    _share(worlds, robots)


@lean_kernel
def step_robots(
    actions: Floats,
    decision: int,
    periods: int,
    reflex_stop_m: float,
    worlds: Worlds,
    robots: Robots,
    problem: Problem,
    outputs: Outputs,
    group: Records,
    work: Workspace,
) -> None:
    """Take all present robots through a decision.

    Args:
        actions: (R,) in [-1, 1].
        decision: Number of decisions taken since the reset.
        periods: Social periods of a decision; ``problem.mechanics`` has one.
        reflex_stop_m: Front range of the reflex stop.
        worlds: A world for each robot; its ``steps`` count decisions, here social periods.
        robots: Their presence and contacts; present robots whose episodes end are marked as absent.
        problem: Parameters of all worlds.
        outputs: Outputs, one row per robot.
        group: Scratch memory, like ``work``.
        work: Workspace for the people of all worlds.
    """
    count = worlds.robots.shape[0]
    robots.contacts[:] = NO_CONTACT
    _share(worlds, robots)
    for i in range(count):
        if robots.present[i]:
            command_world(i, actions[i], reflex_stop_m, worlds, problem, outputs)
    for period in range(periods):
        worlds.steps[:] = decision * periods + period
        _advance_period(worlds, robots, problem, group, work)
    worlds.steps[:] = decision + 1
    for i in range(count):
        if robots.present[i]:
            perceive_world(i, worlds, problem)
            for j in range(count):  # robots are no people to the reward
                worlds.people[i, robots.people + j].status = GONE
            is_over = judge_world(i, robots.contacts[i], worlds, problem, outputs)
            observe_world(i, worlds, problem, outputs)
            robots.present[i] = not is_over


@lean_kernel
def start_robots(
    worlds: Worlds, robots: Robots, problem: Problem, outputs: Outputs, work: Workspace
) -> None:
    """Place all robots at the start of their paths, among people at time zero."""
    m, surroundings = problem.mechanics, surroundings_of(problem)
    for i in range(worlds.robots.shape[0]):
        path = place_of(worlds, i, surroundings).path
        place_robot(
            worlds.robots[i], worlds.wheels[i], path, problem.start_speed_mps, m.drive[0], m.gains
        )
    _share(worlds, robots)
    for i in range(worlds.robots.shape[0]):
        start_people(worlds, i, surroundings, m, work)
    _share(worlds, robots)
    for i in range(worlds.robots.shape[0]):
        perceive_world(i, worlds, problem)
        observe_world(i, worlds, problem, outputs)
