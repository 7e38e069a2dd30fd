"""Batched engine: many worlds as arrays, with the formulas of the pymunk engine.

Contacts, which ``sim/world.py`` leaves to pymunk, are found by ``find_contact``; all other code is
shared. ``advance_group`` takes some worlds through a decision, their robots side by side in lanes,
and allocates nothing; ``envs/batch_step.py`` runs it over all worlds in parallel.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.jit import LANES, scalar
from hazbot_gym.core.own_walking import address_of_model
from hazbot_gym.core.place_table import PlaceTable, place_at
from hazbot_gym.core.recorded_table import RecordedTable, stretch_of
from hazbot_gym.core.social_force import SocialForce
from hazbot_gym.core.state import (
    GAS,
    GONE,
    NO_CONTACT,
    NO_PATTERN,
    PERSON,
    ROBOT,
    TRACK,
    WHEEL,
    Floats,
    Ints,
    Place,
    Records,
    as_record,
)
from hazbot_gym.sim.contact import find_contact, slack
from hazbot_gym.sim.drive import drive_parameters, update_pose_error
from hazbot_gym.sim.lanes import (
    DRIVE_LANES,
    DriveLanes,
    aim_lane,
    drive_step,
    drive_values,
    follow_lane,
    follow_lines,
    load_lane,
    store_lane,
)
from hazbot_gym.sim.people import begin_social_step, end_social_step, move_people
from hazbot_gym.sim.walkers import Workspace, force_values, walk


class Worlds(NamedTuple):
    """The state of N worlds with room for P people each."""

    robots: Records  # (N,) ROBOT
    wheels: Records  # (N, 2) WHEEL
    people: Records  # (N, P) PERSON
    tracks: Records  # (N, P) TRACK, tracker output
    history: Records  # (N, latency + 1, P) TRACK, history of the tracker
    pending: Floats  # (N, latency + 1) pending commands of the drive [m/s]
    ranges: Floats  # (N, sensors) ultrasonic readings [m]
    keys: npt.NDArray[np.uint64]  # (N,) of the scenario
    steps: npt.NDArray[np.int64]  # (N,) decisions taken
    places: npt.NDArray[np.int64]  # (N,) row of the surroundings' places
    starts: npt.NDArray[np.int64]  # (N,) step of the place's recording at which the episode began
    gas: Records  # (N,) GAS; (0,) without gas


class Surroundings(NamedTuple):
    """Places and recordings, shared by worlds."""

    places: PlaceTable
    recorded: RecordedTable


GROUP = np.dtype(
    [
        ("drive", DRIVE_LANES),
        ("world", "i8", (LANES,)),  # index of the world in a lane
        ("contact", "i8", (LANES,)),  # person in contact, WALL or NO_CONTACT
        ("is_near", "i8", (LANES,)),  # 1 if a contact is possible in this social period
    ],
    align=True,
)  # worlds stepped together


class Group(Protocol):
    """One element of an array of ``GROUP``; all fields but the first are arrays over lanes."""

    drive: DriveLanes
    world: Ints
    contact: Ints
    is_near: Ints


class Mechanics(NamedTuple):
    """Parameters of robot and people, shared by all worlds, as arrays for kernels."""

    drive: Records  # (1,) DriveParameters
    gains: Floats  # fuzzy-PID gain table
    force: Records  # (1,) SocialForce
    reactions: Records  # (4,) Reaction
    own_model: int  # address of a user's pedestrian model
    physics_per_social: int
    social_per_decision: int
    physics_s: float
    social_s: float


def allocate(
    worlds: int, people: int, sensors: int, *, tracker_latency: int, drive_latency: int,
    has_gas: bool,
) -> Worlds:  # fmt: skip
    """Return the arrays of N worlds; every world must be reset before its first step."""
    return Worlds(
        robots=np.zeros(worlds, ROBOT),
        wheels=np.zeros((worlds, 2), WHEEL),
        people=np.zeros((worlds, people), PERSON),
        tracks=np.zeros((worlds, people), TRACK),
        history=np.zeros((worlds, tracker_latency + 1, people), TRACK),
        pending=np.zeros((worlds, drive_latency + 1)),
        ranges=np.zeros((worlds, sensors)),
        keys=np.zeros(worlds, np.uint64),
        steps=np.zeros(worlds, np.int64),
        places=np.zeros(worlds, np.int64),
        starts=np.zeros(worlds, np.int64),
        gas=np.zeros(worlds if has_gas else 0, GAS),
    )


def with_room(worlds: Worlds, people: int) -> Worlds:
    """Return copies of the arrays with room for more people each; nobody is there yet."""
    more = people - worlds.people.shape[1]

    def widened(array: Records) -> Records:
        blank = np.zeros((*array.shape[:-1], more), array.dtype)
        if "status" in (array.dtype.names or ()):
            blank["status"] = GONE
        if "pattern" in (array.dtype.names or ()):
            blank["pattern"] = NO_PATTERN
        return np.concatenate([array, blank], axis=-1)

    return worlds._replace(
        people=widened(worlds.people),
        tracks=widened(worlds.tracks),
        history=widened(worlds.history),
    )


def mechanics(config: Config) -> Mechanics:
    """Return the parameters of robot and people for a config."""
    return Mechanics(
        drive=as_record(drive_parameters(config.drive, config.clock.physics_s)),
        gains=gain_table(config.drive.tables),
        force=as_record(config.people.force),
        reactions=np.concatenate([as_record(r) for r in config.people.reactions]),
        own_model=address_of_model(config.people.model),
        physics_per_social=config.clock.physics_per_social,
        social_per_decision=config.clock.social_per_decision,
        physics_s=config.clock.physics_s,
        social_s=config.clock.social_s,
    )


@scalar
def place_of(worlds: Worlds, i: int, surroundings: Surroundings) -> Place:
    """Return the place of world i."""
    return place_at(surroundings.places, worlds.places[i])


@scalar
def begin_social_period(
    worlds: Worlds, i: int, surroundings: Surroundings, m: Mechanics, force: SocialForce,
    step: int, work: Workspace, walkers: int,
) -> int:  # fmt: skip
    """Load the people of world i into the workspace; return its number of walkers."""
    recording = stretch_of(surroundings.recorded, worlds.places[i], worlds.starts[i])
    return begin_social_step(
        worlds.people[i], place_of(worlds, i, surroundings), worlds.robots[i], force,
        m.reactions, m.own_model, recording, worlds.keys[i], step, m.social_s, work, walkers,
    )  # fmt: skip


@scalar
def start_people(
    worlds: Worlds, i: int, surroundings: Surroundings, m: Mechanics, work: Workspace
) -> None:
    """Compute the first velocities of the people of world i."""
    place, force = place_of(worlds, i, surroundings), force_values(m.force[0])
    count = begin_social_period(worlds, i, surroundings, m, force, 0, work, 0)
    walk(work, count, force, m.social_s)
    end_social_step(worlds.people[i], place, worlds.robots[i], m.social_s, work, 0)


@scalar
def advance_group(
    group: Group, count: int, worlds: Worlds, surroundings: Surroundings, m: Mechanics,
    work: Workspace,
) -> None:  # fmt: skip
    """Drive and walk some worlds for a decision period at their robots' effective commands.

    A world freezes after a contact.

    Args:
        group: Record of type ``GROUP``: worlds as input, contacts as output.
        count: Number of lanes in use.
        worlds: All worlds, changed in place.
        surroundings: Their places.
        m: Parameters of robot and people.
        work: Workspace for all people of the group.
    """
    for lane in range(count):
        i = group.world[lane]
        group.contact[lane] = NO_CONTACT
        step = worlds.steps[i] * m.social_per_decision * m.physics_per_social
        load_lane(group.drive, lane, worlds.robots[i], worlds.wheels[i], worlds.keys[i], step)
    for period in range(m.social_per_decision):
        _drive_period(group, count, worlds, surroundings, m)
        _walk_period(group, count, period, worlds, surroundings, m, work)


@scalar
def _walk_period(
    group: Group, count: int, period: int, worlds: Worlds, surroundings: Surroundings,
    m: Mechanics, work: Workspace,
) -> None:  # fmt: skip
    """Move a group's people to the end of a social period, and compute their next velocities."""
    force, walkers = force_values(m.force[0]), 0
    for lane in range(count):
        i = group.world[lane]
        if group.contact[lane] == NO_CONTACT:
            store_lane(group.drive, lane, worlds.robots[i], worlds.wheels[i])
            update_pose_error(worlds.robots[i], place_of(worlds, i, surroundings).path)
            move_people(worlds.people[i], m.social_s)
            step = worlds.steps[i] * m.social_per_decision + period + 1
            walkers = begin_social_period(worlds, i, surroundings, m, force, step, work, walkers)
    walk(work, walkers, force, m.social_s)
    walkers = 0
    for lane in range(count):
        i = group.world[lane]
        if group.contact[lane] == NO_CONTACT:
            place = place_of(worlds, i, surroundings)
            walkers = end_social_step(
                worlds.people[i], place, worlds.robots[i], m.social_s, work, walkers
            )


@scalar
def _drive_period(
    group: Group, count: int, worlds: Worlds, surroundings: Surroundings, m: Mechanics
) -> None:
    """Drive a group's robots for a social period; check contacts where something is near."""
    for lane in range(count):
        i = group.world[lane]
        walls = place_of(worlds, i, surroundings).walls
        nearest = slack(worlds.people[i], walls, worlds.robots[i], m.social_s)
        group.is_near[lane] = nearest <= 0.0 and group.contact[lane] == NO_CONTACT
    p = drive_values(m.drive[0])
    for lane in range(count):
        path = place_of(worlds, group.world[lane], surroundings).path
        aim_lane(group.drive, lane, path, p.nominal_speed_mps * m.social_s)
    for k in range(m.physics_per_social):
        follow_lines(group.drive)
        for lane in range(count):
            follow_lane(group.drive, lane, place_of(worlds, group.world[lane], surroundings).path)
        drive_step(group.drive, p, m.gains)
        for lane in range(count):
            if group.is_near[lane]:
                _look_for_contact(group, lane, (k + 1) * m.physics_s, worlds, surroundings)


@scalar
def _look_for_contact(
    group: Group, lane: int, elapsed_s: float, worlds: Worlds, surroundings: Surroundings
) -> None:
    """Record the contact of the robot in a lane; a contact freezes its world."""
    i = group.world[lane]
    robot, people, place = worlds.robots[i], worlds.people[i], place_of(worlds, i, surroundings)
    robot.x, robot.y = group.drive.x[lane], group.drive.y[lane]
    contact = find_contact(people, place.walls, robot, elapsed_s)
    if contact != NO_CONTACT:
        group.contact[lane], group.is_near[lane] = contact, False
        store_lane(group.drive, lane, robot, worlds.wheels[i])
        update_pose_error(robot, place.path)
        move_people(people, elapsed_s)
