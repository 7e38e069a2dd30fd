"""Model people who meet a recorded robot: the robot as recorded, the people's way the model's.

A person stands at its first recorded position until it starts to walk there, walks to its last one
at its own pace, and stands. Pace and waypoints are recorded; the waypoints are so coarse that they
keep corners of the room but no evasion. People who stand where they meet the robot stay there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.hooks import NO_HOOK
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.recorded_table import NO_STRETCH, Stretch
from hazbot_gym.core.social_force import Reaction, SocialForce
from hazbot_gym.core.state import (
    GONE,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    SOCIAL_FORCE,
    Floats,
    Place,
    Records,
    as_record,
    records,
)
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.walkers import Workspace, make_workspace
from hazbot_gym.task.encounter_place import simplified
from hazbot_gym.task.place_data import pad_routes
from hazbot_gym.task.tracks import RecordedRobot, Recording

DT_S = 0.05  # social period
WALKING_MPS = 0.3  # a slower person stands
PACE_PERCENTILE = 75.0  # of the speeds of a walking person
COARSE_M = 0.6  # tolerance of waypoints: wider than an evasion
NEAR_M = 3.0  # distance between centers within which a person's speed is compared
STARTING_S = 1.0  # after the start and before the end of a walk, in which speed is not compared
WINDOW = 5  # samples of a moving average of speed
_NOWHERE = np.array([1.0, 0.0])  # direction of the route of a standing person


class Walk(NamedTuple):
    """Recorded walk of a person through an encounter."""

    first: int  # first step of walking, and the step after the last; the same if it stands
    end: int
    pace_mps: float  # 0 if it stands
    waypoints: Floats  # (n, 2) [m]


class Meeting(NamedTuple):
    """An encounter, ready for simulation."""

    robot: RecordedRobot
    dt_s: float  # of the recording
    people: Floats  # (T, P, 2) recorded positions [m]
    walks: tuple[Walk, ...]


class Outcome(NamedTuple):
    """Closest distance between centers and slowest relative speed in an encounter."""

    closest_m: float
    slowest: float  # share of the own pace within NEAR_M; NaN if no person walks there


def meeting_of(recording: Recording) -> Meeting | None:
    """Return an encounter whose people are all seen throughout, else None."""
    assert recording.robot is not None, "it is a recording of an encounter"
    steps = len(recording.robot.positions)
    if np.any(recording.first_steps != 0) or np.any(recording.lengths != steps):
        return None
    people = np.stack(recording.tracks(), axis=1)
    walks = tuple(
        _walk(track, recording.robot.positions, recording.dt_s) for track in recording.tracks()
    )
    return Meeting(recording.robot, recording.dt_s, people, walks)


def _walk(track: Floats, robot: Floats, dt_s: float) -> Walk:
    distance_m, speed_mps = np.hypot(*(track - robot).T), _speeds(track, dt_s)
    near = distance_m < max(NEAR_M, float(distance_m.min()) + 0.1)
    walking = np.flatnonzero(speed_mps > WALKING_MPS)
    if len(walking) < WINDOW or np.median(speed_mps[near]) < WALKING_MPS:
        place = track[int(distance_m.argmin())]
        return Walk(0, 0, 0.0, np.stack([place, place + _NOWHERE]))
    first, end = int(walking[0]), int(walking[-1]) + 1
    pace_mps = float(np.percentile(speed_mps[first:end], PACE_PERCENTILE))
    return Walk(first, end, pace_mps, simplified(track[first:end], COARSE_M))


def _speeds(track: Floats, dt_s: float) -> Floats:
    """Return the speeds of positions (T, ..., 2) [m/s]."""
    speeds: Floats = np.linalg.norm(np.gradient(track, dt_s, axis=0), axis=-1)
    return speeds


def recorded_outcome(meeting: Meeting) -> Outcome:
    """Return the recorded outcome of an encounter."""
    ends = [walk.end for walk in meeting.walks]
    return _outcome(meeting, meeting.people, ends)


def _outcome(meeting: Meeting, people: Floats, ends: list[int]) -> Outcome:
    """Return the outcome for people (T, P, 2), walking up to some steps."""
    distance_m = np.linalg.norm(people - meeting.robot.positions[:, None], axis=2)
    speed_mps, steps = _speeds(people, meeting.dt_s), np.arange(len(people))
    margin, slowest = round(STARTING_S / meeting.dt_s), []
    for i, (walk, end) in enumerate(zip(meeting.walks, ends, strict=True)):
        under_way = (steps >= walk.first + margin) & (steps < end - margin)
        speeds = speed_mps[under_way & (distance_m[:, i] < NEAR_M), i]
        if walk.pace_mps > 0.0 and len(speeds) >= WINDOW:
            mean = np.convolve(speeds, np.full(WINDOW, 1.0 / WINDOW), "valid")
            slowest.append(float(mean.min()) / walk.pace_mps)
    return Outcome(float(distance_m.min()), min(slowest, default=np.nan))


# --- the model -----------------------------------------------------------------------------------


class Stage(NamedTuple):
    """Arrays of an encounter for the simulation."""

    meeting: Meeting
    people: Records  # (P,) PERSON records at time zero
    starts: Floats  # (P, 2) time of the start of walking [s], and pace [m/s]
    place: Place
    track: Floats  # (T, 4) x, y, heading and speed of the robot at every social step
    work: Workspace


def stage_of(meeting: Meeting, like: Place) -> Stage:
    """Return an encounter's arrays; walls and path of a place are not used."""
    people = records(PERSON, len(meeting.walks))
    # Robot and person act on each other by the sum of their radii only, and the model's robot has
    # a fixed one: the people carry the difference.
    people["radius"] = PERSON_RADIUS_M + meeting.robot.radius_m - ROBOT_RADIUS_M
    people["model"], people["status"] = SOCIAL_FORCE, PRESENT
    people["route"] = np.arange(len(people))
    for person, walk in zip(people, meeting.walks, strict=True):
        person["x"], person["y"] = walk.waypoints[0]
    alike = np.zeros(len(people))
    place = like._replace(
        walls=np.zeros((0, 4)),
        routes=pad_routes([walk.waypoints for walk in meeting.walks]),
        route_kinds=alike.astype(np.int64),
        route_anchors=np.zeros((len(people), 2)),
        route_rooms=alike,
    )
    starts = np.array([(walk.first * meeting.dt_s, walk.pace_mps) for walk in meeting.walks])
    return Stage(meeting, people, starts, place, _robot_track(meeting), make_workspace(len(people)))


def _robot_track(meeting: Meeting) -> Floats:
    """Return the robot's position, heading and speed at every social step (T, 4)."""
    known_s = np.arange(len(meeting.robot.positions)) * meeting.dt_s
    times_s = np.arange(int(known_s[-1] / DT_S + 1e-9) + 1) * DT_S
    positions = np.stack(
        [np.interp(times_s, known_s, axis) for axis in meeting.robot.positions.T], axis=1
    )
    velocity = np.gradient(positions, DT_S, axis=0)
    heading = np.arctan2(velocity[:, 1], velocity[:, 0])
    return np.column_stack([positions, heading, np.hypot(*velocity.T)])


def model_outcome(stage: Stage, force: SocialForce, reaction: Reaction, *, key: int) -> Outcome:
    """Return the outcome of an encounter with model people of one reaction."""
    people, robot = stage.people.copy(), records(ROBOT, 1)
    seen = np.zeros((len(stage.track), len(people), 3))
    _simulate(
        people, robot, stage.starts, stage.place, stage.track, as_record(force),
        as_record(reaction), NO_STRETCH, np.uint64(key), DT_S, stage.work, seen,
    )  # fmt: skip
    every = round(stage.meeting.dt_s / DT_S)
    seen = seen[::every][: len(stage.meeting.people)]
    ends = [int(walks.sum()) for walks in (seen[..., 2] < GONE).T]
    return _outcome(stage.meeting, seen[..., :2], ends)


@lean_kernel
def _simulate(
    people: Records, robots: Records, starts: Floats, place: Place, track: Floats, force: Records,
    reaction: Records, recording: Stretch, key: np.uint64, dt_s: float, work: Workspace,
    seen: Floats,
) -> None:  # fmt: skip
    """Write position and status of everyone (T, P, 3) beside a robot on a track."""
    robot = robots[0]
    for step in range(track.shape[0]):
        robot.x, robot.y, robot.theta = track[step, 0], track[step, 1], track[step, 2]
        robot.v = track[step, 3]
        for i in range(people.shape[0]):
            people[i].desired_speed = starts[i, 1] if step * dt_s >= starts[i, 0] else 0.0
        social_step(
            people, place, robot, force[0], reaction, NO_HOOK, recording, key, step, dt_s, work
        )
        for i in range(people.shape[0]):
            seen[step, i, 0], seen[step, i, 1] = people[i].x, people[i].y
            seen[step, i, 2] = people[i].status
        move_people(people, dt_s)
