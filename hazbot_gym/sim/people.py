"""Pedestrian simulation: a social step computes velocities, constant until the next step.

Four models share one record type: scripted walkers follow their route without reacting,
social-force walkers react to people, walls and the robot, replayed people follow a recording, and
others walk by a model of a user.
Velocities are updated simultaneously, from the previous ones.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.entries import pass_on
from hazbot_gym.core.geometry import norm, route_pose
from hazbot_gym.core.jit import routine, scalar
from hazbot_gym.core.recorded_table import Stretch, rows_of, stay_at
from hazbot_gym.core.social_force import SocialForce
from hazbot_gym.core.state import (
    GONE,
    OWN,
    PRESENT,
    REPLAY,
    ROBOT_RADIUS_M,
    SCRIPTED,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    PersonRecord,
    Place,
    Records,
    RobotRecord,
)
from hazbot_gym.sim.own_people import walk_by_own_model
from hazbot_gym.sim.spacing import ROBOT_MARGIN_M, keep_off_robot
from hazbot_gym.sim.walkers import Workspace, force_values, put_down, take_up, walk
from hazbot_gym.sim.walking import lane_point

ENTRY_ROOM_M = 0.45  # required distance to other people at entry
ROBOT_ENTRY_ROOM_M = 2.0  # and to the robot
CATCH_UP_MPS = 2.5  # rate of return of a replayed person to its track after avoiding the robot


@scalar
def _is_clear(people: Records, i: int, robot: RobotRecord) -> bool:
    """Return True if there is room for person i to enter."""
    me = people[i]
    if norm(robot.x - me.x, robot.y - me.y) < ROBOT_ENTRY_ROOM_M:
        return False
    for j in range(people.shape[0]):
        other = people[j]
        if other.status == PRESENT and norm(other.x - me.x, other.y - me.y) < ENTRY_ROOM_M:
            return False
    return True


@scalar
def _follow_script(me: PersonRecord, routes: Floats, dt_s: float) -> None:
    """Set the next velocity of a scripted walker such that the step ends on its lane."""
    x, y = lane_point(routes, me, me.s + me.desired_speed * dt_s)
    me.next_vx = (x - me.x) / dt_s
    me.next_vy = (y - me.y) / dt_s


@scalar
def _follow_recording(
    people: Records, i: int, robot: RobotRecord, recording: Stretch, step: int, dt_s: float
) -> None:
    """Set the next velocity of replayed person i.

    People follow the recording, but avoid the robot, which the recording does not contain.
    """
    me = people[i]
    if step + 1 >= recording.steps:
        me.status = GONE
        return
    row, end = rows_of(recording, me.route if me.status == PRESENT else -1, step)
    if row + 1 >= end:
        me.route = stay_at(recording, i, step)
        row, end = rows_of(recording, me.route, step)
    if row + 1 >= end:
        me.status = WAITING
        return
    if me.status != PRESENT:
        me.x, me.y = recording.positions[row, 0], recording.positions[row, 1]
        if norm(robot.x - me.x, robot.y - me.y) < me.radius + ROBOT_RADIUS_M + ROBOT_MARGIN_M:
            return
        me.status = PRESENT
    vx = (recording.positions[row + 1, 0] - me.x) / dt_s
    vy = (recording.positions[row + 1, 1] - me.y) / dt_s
    speed = norm(vx, vy)
    if speed > CATCH_UP_MPS:
        vx *= CATCH_UP_MPS / speed
        vy *= CATCH_UP_MPS / speed
    me.next_vx, me.next_vy = keep_off_robot(me, robot, vx, vy, dt_s, True)
    me.desired_speed = min(speed, CATCH_UP_MPS)


@scalar
def _enter(people: Records, i: int, robot: RobotRecord, time_s: float) -> None:
    """Let a person enter at its start time; reactive people wait until there is room."""
    me = people[i]
    if time_s < me.enters_s - 1e-9:
        return
    if me.model == SCRIPTED or _is_clear(people, i, robot):
        me.status = PRESENT


@scalar
def _advance(me: PersonRecord, routes: Floats, dt_s: float) -> None:
    """Update a walker's progress along its route; remove it at the end."""
    if me.model == SCRIPTED:
        me.s += me.desired_speed * dt_s
    else:
        x, y, tx, ty = route_pose(routes, me.route, me.s)
        me.s = max(me.s + (me.x - x) * tx + (me.y - y) * ty, 0.0)
    if me.s >= routes[me.route, routes.shape[1] - 1, 2]:
        me.status = GONE


@routine
def begin_social_step(
    people: Records, place: Place, robot: RobotRecord, force: SocialForce, reactions: Records,
    own_model: int, recording: Stretch, key: np.uint64, step: int, dt_s: float, work: Workspace,
    walkers: int,
) -> int:  # fmt: skip
    """Add and remove people, and load the social-force walkers into the workspace.

    Arguments as in ``social_step``, and the number of walkers already in the workspace. Returns the
    new number.
    """
    for i in range(people.shape[0]):
        me = people[i]
        if me.model != REPLAY and me.status == PRESENT and step > 0:
            _advance(me, place.routes, dt_s)
            me.left_s = step * dt_s
        elif place.entry_times_s.shape[0] > 0:
            pass_on(people, i, place, step * dt_s)
        if me.model != REPLAY and me.status == WAITING:
            _enter(people, i, robot, step * dt_s)
    sine, cosine = sin_cos(robot.theta)
    robot_vx, robot_vy = robot.v * cosine, robot.v * sine
    for i in range(people.shape[0]):
        me = people[i]
        if me.model == REPLAY:
            _follow_recording(people, i, robot, recording, step, dt_s)
        elif me.status == PRESENT:
            if me.model == SCRIPTED:
                _follow_script(me, place.routes, dt_s)
            elif me.model == OWN:
                walk_by_own_model(
                    own_model, people, i, place, robot, reactions[me.reaction], key, step, dt_s
                )
            else:
                take_up(
                    work, walkers, people, i, place, robot, robot_vx, robot_vy, force,
                    reactions[me.reaction], key, step,
                )  # fmt: skip
                walkers += 1
    return walkers


@routine
def end_social_step(
    people: Records, place: Place, robot: RobotRecord, dt_s: float, work: Workspace, walkers: int
) -> int:
    """Store the chosen velocities; ``walkers`` is the number of earlier walkers in the workspace.

    Returns: The number including this world's walkers.
    """
    for i in range(people.shape[0]):
        if people[i].model == SOCIAL_FORCE and people[i].status == PRESENT:
            put_down(work, walkers, people, i, place, robot, dt_s)
            walkers += 1
    for i in range(people.shape[0]):
        me = people[i]
        is_there = me.status == PRESENT
        me.vx = me.next_vx if is_there else 0.0
        me.vy = me.next_vy if is_there else 0.0
    return walkers


@scalar
def social_step(
    people: Records, place: Place, robot: RobotRecord, force: SocialForce, reactions: Records,
    own_model: int, recording: Stretch, key: np.uint64, step: int, dt_s: float, work: Workspace,
) -> None:  # fmt: skip
    """Compute the velocity of every person of one world for the next social period.

    Args:
        people: (P,) PERSON records, changed in place.
        place: Walls and routes.
        robot: The robot's record.
        force: Constants of the walking model (a record with the fields of ``SocialForce``).
        reactions: (4,) records of ``Reaction``.
        own_model: Address of the model of people whose model is OWN.
        recording: Followed by people whose model is REPLAY.
        key: Key of the scenario's noise.
        step: Number of this social step since the reset.
        dt_s: Social period [s].
        work: Workspace for P walkers.
    """
    values = force_values(force)
    count = begin_social_step(
        people, place, robot, values, reactions, own_model, recording, key, step, dt_s, work, 0
    )
    walk(work, count, values, dt_s)
    end_social_step(people, place, robot, dt_s, work, 0)


@scalar
def move_people(people: Records, dt_s: float) -> None:
    """Move all present people at constant velocity for some time."""
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            me.x += me.vx * dt_s
            me.y += me.vy * dt_s
