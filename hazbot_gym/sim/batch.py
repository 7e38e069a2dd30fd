"""The batched engine: many worlds as arrays, stepped by the formulas of the pymunk engine.

What ``sim/world.py`` asks pymunk for, contacts, is answered here by ``find_contact``; everything
else is shared line by line. ``step_world`` advances one world by one decision and allocates
nothing; ``envs/batch.py`` runs it over all worlds in parallel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import (
    NO_CONTACT,
    PERSON,
    ROBOT,
    TRACK,
    WHEEL,
    Floats,
    Place,
    Record,
    Records,
    as_record,
)
from hazbot_gym.sim.contact import find_contact, slack
from hazbot_gym.sim.drive import drive_parameters, drive_substep, update_pose_error
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.perception import SENSORS


class Worlds(NamedTuple):
    """The state of N worlds with room for P people each."""

    robots: Records  # (N,) ROBOT
    wheels: Records  # (N, 2) WHEEL
    people: Records  # (N, P) PERSON
    tracks: Records  # (N, P) TRACK, what the tracker reports
    history: Records  # (N, latency + 1, P) TRACK, the tracker's memory
    ranges: Floats  # (N, 4) ultrasonic readings [m]
    keys: npt.NDArray[np.uint64]  # (N,) of the scenario
    steps: npt.NDArray[np.int64]  # (N,) decisions taken


class Mechanics(NamedTuple):
    """What is the same in all worlds: parameters of robot and people, ready for kernels."""

    drive: Records  # (1,) DriveParameters
    gains: Floats  # fuzzy-PID gain table
    force: Records  # (1,) SocialForce
    reactions: Records  # (4,) Reaction
    physics_per_social: int
    social_per_decision: int
    physics_s: float
    social_s: float


def allocate(worlds: int, people: int, latency_steps: int) -> Worlds:
    """Return the arrays of N worlds; every world is to be reset before it is stepped."""
    return Worlds(
        robots=np.zeros(worlds, ROBOT),
        wheels=np.zeros((worlds, 2), WHEEL),
        people=np.zeros((worlds, people), PERSON),
        tracks=np.zeros((worlds, people), TRACK),
        history=np.zeros((worlds, latency_steps + 1, people), TRACK),
        ranges=np.zeros((worlds, SENSORS)),
        keys=np.zeros(worlds, np.uint64),
        steps=np.zeros(worlds, np.int64),
    )


def mechanics(config: Config) -> Mechanics:
    """Return the parameters of robot and people for a config."""
    return Mechanics(
        drive=as_record(drive_parameters(config.drive, config.clock.physics_s)),
        gains=gain_table(config.drive.tables),
        force=as_record(config.people.force),
        reactions=np.concatenate([as_record(r) for r in config.people.reactions]),
        physics_per_social=config.clock.physics_per_social,
        social_per_decision=config.clock.social_per_decision,
        physics_s=config.clock.physics_s,
        social_s=config.clock.social_s,
    )


@scalar
def step_world(
    robot: Record, wheels: Records, people: Records, place: Place, m: Mechanics, recording: Floats,
    key: np.uint64, decision: int,
) -> int:  # fmt: skip
    """Drive one world for a decision period at ``robot.command``; return the contact, if any.

    Args:
        robot: The robot's record, changed in place like wheels and people.
        wheels: (2,) WHEEL records.
        people: (P,) PERSON records.
        place: Walls, path and routes.
        m: Parameters of robot and people.
        recording: (T, P, 2) positions at every social step [m] for replayed people, else (0, 0, 2).
        key: Key of the scenario's noise.
        decision: Decisions taken so far.

    Returns:
        Index of the person touched, ``WALL`` or ``NO_CONTACT``; after a contact time stands still.
    """
    first = decision * m.social_per_decision
    for period in range(first, first + m.social_per_decision):
        is_near = slack(people, place.walls, robot, m.social_s) <= 0.0
        for k in range(m.physics_per_social):
            step = period * m.physics_per_social + k
            drive_substep(robot, wheels, place.path, m.drive[0], m.gains, key, step)
            if is_near:
                elapsed_s = (k + 1) * m.physics_s
                contact = find_contact(people, place.walls, robot, elapsed_s)
                if contact != NO_CONTACT:
                    move_people(people, elapsed_s)
                    update_pose_error(robot, place.path)
                    return contact
        update_pose_error(robot, place.path)
        move_people(people, m.social_s)
        social_step(
            people, place, robot, m.force[0], m.reactions, recording, key, period + 1, m.social_s
        )
    return NO_CONTACT
