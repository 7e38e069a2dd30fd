"""Recorded people in scenarios: replayed, or used to seed social-force walkers.

Replayed people follow the recording and only avoid overlap with the robot. Seeding uses each
person's entry time and place, speed and exit; the social force model determines the rest, so that
these people react to the robot.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from hazbot_gym.core.entries import REST_S, seat
from hazbot_gym.core.geometry import path_length
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.noise import SCENARIO, uniform4
from hazbot_gym.core.place_table import PlaceTable
from hazbot_gym.core.recorded_table import RecordedTable, Stretch, rows_from, stretch_of
from hazbot_gym.core.state import (
    AGAINST,
    GONE,
    PERSON_RADIUS_M,
    REPLAY,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Records,
)
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.crowd import choose_reaction
from hazbot_gym.task.encounter_place import encounter_place
from hazbot_gym.task.place_data import PathData, PlaceData, build_place, pad_routes
from hazbot_gym.task.replay_place import replay_frame
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_folders import find_recordings, load_tracks
from hazbot_gym.task.track_statistics import Entries, entries
from hazbot_gym.task.tracks import Recording, resample, steps_on_clock

ATTEMPTS = 8  # attempts to find a moment with a free start of the robot
START_ROOM_M = 1.5  # free distance to people at the start
SHORTEST_WAY_M = 1.0  # minimum distance from entry to exit of seeded walkers
EMPTY_STEPS = 4  # gap between two people in a slot, so that decisions separate them


def load_recordings(tracks: str | None) -> list[Recording]:
    """Return the recordings of a file or folder; default the synthetic recording.

    Raises:
        InvalidInput: There is no such file or folder, or a file in it cannot be used.
    """
    if tracks is None:
        return [synthetic_recording()]
    return load_tracks(tracks)


def tracks_files(tracks: str | None) -> list[Path]:
    """Return the input files of ``load_recordings``: tables, and their descriptions.

    Raises:
        InvalidInput: There is no such file or folder, or no recording in it.
    """
    if tracks is None:
        return []
    tables = find_recordings(tracks)
    descriptions = [table.with_suffix(".json") for table in tables]
    return tables + [path for path in descriptions if path.exists() and path not in tables]


def recorded_places(recordings: list[Recording], *, with_entries: bool) -> list[Place]:
    """Return the directions through each recording, optionally with the people's own routes.

    There are two directions, but only the robot's direction for a recording with a robot.
    """
    places = []
    for recording in recordings:
        for is_reversed in directions(recording):
            place = _place(recording, is_reversed=is_reversed)
            places.append(_with_entry_routes(place, recording) if with_entries else place)
    return places


def directions(recording: Recording) -> tuple[bool, ...]:
    """Return the directions through a recording: True is reversed."""
    return (False, True) if recording.robot is None else (False,)


def recorded_table(recordings: list[Recording], dt_s: float) -> RecordedTable:
    """Return the recordings as arrays on a clock [s]."""
    on_clock = [resample(recording, dt_s) for recording in recordings]
    in_slots = [_in_slots(recording) for recording in on_clock]
    width = max(len(slots) for slots in in_slots)
    slots = np.zeros((len(recordings), width + 1), np.int64)
    firsts: list[int] = []
    tracks = [np.zeros((0, 2))]
    for row, recording, people_in in zip(slots, on_clock, in_slots, strict=True):
        positions = recording.tracks()
        for slot, people in enumerate(people_in):
            row[slot] = len(firsts)
            firsts += recording.first_steps[people].tolist()
            tracks += [positions[person] for person in people]
        row[len(people_in) :] = len(firsts)
    counts = np.array([len(directions(recording)) for recording in recordings])
    first = np.cumsum(counts) - counts  # place of each recording, as in ``recorded_places``
    return RecordedTable(
        dt_s=dt_s,
        recording_of_place=np.repeat(np.arange(len(recordings)), counts),
        ways=np.stack([first, first + counts - 1], axis=1),
        counts=np.array([steps_on_clock(recording, dt_s) for recording in recordings]),
        slots=slots,
        firsts=np.array(firsts, np.int64),
        offsets=np.cumsum([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
    )


def most_at_once(places: list[Place], duration_s: float) -> int:
    """Return the number of simultaneous records needed, with a margin for delayed people.

    Args:
        places: Places with entries.
        duration_s: Duration of an episode; later entries need no record [s].
    """
    return max(min(_together(place), _within(place, duration_s)) for place in places)


def _together(place: Place) -> int:
    """Return 1.5 times the maximum number of simultaneous people at their own speeds."""
    ways_m = place.routes[:, -1, 2]
    ends_s = np.sort(place.entry_times_s + ways_m / place.entry_speeds_mps + REST_S)
    gone = np.searchsorted(ends_s, place.entry_times_s, side="right")
    there = np.arange(1, len(ends_s) + 1) - gone
    return math.ceil(1.5 * float(there.max(initial=1)))


def _within(place: Place, duration_s: float) -> int:
    """Return the maximum number of entries within a duration."""
    times_s = place.entry_times_s
    inside = np.searchsorted(times_s, times_s + duration_s) - np.arange(len(times_s))
    return int(inside.max(initial=1))


def _place(recording: Recording, *, is_reversed: bool) -> Place:
    if recording.robot is not None:
        return encounter_place(recording.name, recording.robot)
    frame = replay_frame(recording, is_reversed=is_reversed)
    points = [(float(x), float(y)) for x, y in (frame.start, frame.end)]
    walls = [(float(a), float(b), float(c), float(d)) for a, b, c, d in frame.walls]
    return build_place(PlaceData(name=recording.name, walls=walls, path=PathData(points=points)))


def _entries(recording: Recording) -> Entries:
    """Return the entries, without people who leave where they entered."""
    came = entries(inside_corridor(recording))
    is_way = np.hypot(*(came.exit_points - came.entry_points).T) >= SHORTEST_WAY_M
    return Entries(*(column[is_way] for column in came))


def _with_entry_routes(place: Place, recording: Recording) -> Place:
    """Return the place with a straight route for each person, from entry to exit."""
    came = _entries(recording)
    ends = [np.stack(pair) for pair in zip(came.entry_points, came.exit_points, strict=True)]
    routes = pad_routes(ends) if ends else np.zeros((0, 2, 3))
    return place._replace(
        routes=routes,
        route_kinds=np.full(len(routes), AGAINST),
        route_anchors=np.zeros((len(routes), 2)),
        route_rooms=np.zeros(len(routes)),
        entry_times_s=came.times_s,
        entry_speeds_mps=came.speeds_mps,
    )


def inside_corridor(recording: Recording) -> Recording:
    """Return the recording cut to the corridor, in which straight routes are free of walls."""
    if recording.corridor is None:
        return recording
    (x1, x2), (y1, y2) = recording.corridor.x_m, recording.corridor.y_m
    ids, firsts, tracks = [], [], []
    for i, track in enumerate(recording.tracks()):
        x, y = track.T
        inside = np.flatnonzero((x >= x1) & (x <= x2) & (y >= y1) & (y <= y2))
        if len(inside):
            ids.append(recording.ids[i])
            firsts.append(recording.first_steps[i] + inside[0])
            tracks.append(track[inside[0] : inside[-1] + 1])
    if not tracks:
        raise InvalidInput(f"tracks: no person of {recording.name} enters its corridor")
    return replace(
        recording,
        ids=np.array(ids),
        first_steps=np.array(firsts),
        lengths=np.array([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
    )


def _in_slots(recording: Recording) -> list[list[int]]:
    """Assign people to slots by first fit; return the consecutive people of each slot."""
    slots: list[list[int]] = []
    free: list[int] = []  # heaps: free slots by number, and occupied slots by end
    taken: list[tuple[int, int]] = []
    ends = recording.first_steps + recording.lengths + EMPTY_STEPS
    for person in np.argsort(recording.first_steps, kind="stable").tolist():
        while taken and taken[0][0] <= recording.first_steps[person]:
            heapq.heappush(free, heapq.heappop(taken)[1])
        if not free:
            free.append(len(slots))
            slots.append([])
        slot = heapq.heappop(free)
        slots[slot].append(person)
        heapq.heappush(taken, (int(ends[person]), slot))
    return slots


# --- drawing -------------------------------------------------------------------------------------


@scalar
def _is_start_free(stretch: Stretch, x: float, y: float) -> bool:
    for slot in range(stretch.slots.shape[0] - 1):
        row, end = rows_from(stretch, slot, 0)
        if row < end:
            dx, dy = stretch.positions[row, 0] - x, stretch.positions[row, 1] - y
            if dx * dx + dy * dy < START_ROOM_M * START_ROOM_M:
                return False
    return True


@scalar
def draw_stretch(
    table: RecordedTable, places: PlaceTable, key: np.uint64, nominal_speed_mps: float
) -> tuple[int, int]:
    """Draw the place, and the first step in its recording.

    The rest of the recording lasts at least twice the travel time at nominal speed, if possible.
    """
    u_which, u_way, _, _ = uniform4(key, SCENARIO, 0, 0)
    which = min(int(u_which * table.counts.shape[0]), table.counts.shape[0] - 1)
    place = table.ways[which, 1 if u_way < 0.5 else 0]
    path = places.paths[place, : places.path_counts[place]]
    needed = int(2.0 * path_length(path) / nominal_speed_mps / table.dt_s)
    latest = max(table.counts[which] - 1 - needed, 0)
    start = 0
    for attempt in range(ATTEMPTS):
        start = int(latest * uniform4(key, SCENARIO, attempt, 1)[0])
        if _is_start_free(stretch_of(table, place, start), path[0].x, path[0].y):
            break
    return place, start


@scalar
def fill_replayed(people: Records) -> None:
    """Write replayed people, one per slot of a recording."""
    for i in range(people.shape[0]):
        me = people[i]
        me.model, me.status, me.radius, me.route = REPLAY, WAITING, PERSON_RADIUS_M, i


@scalar
def fill_seeded(
    people: Records, place: Place, start_s: float, shares: Floats, key: np.uint64
) -> None:
    """Write social-force people with the entries of a recording from a moment on."""
    first = 0
    while first < place.entry_times_s.shape[0] and place.entry_times_s[first] < start_s:
        first += 1
    for i in range(people.shape[0]):
        me = people[i]
        me.model, me.radius = SOCIAL_FORCE, PERSON_RADIUS_M
        me.reaction = choose_reaction(uniform4(key, SCENARIO, 0, 2 + i)[0], shares)
        if first + i < place.entry_times_s.shape[0]:
            seat(me, place, first + i, start_s)
        else:  # no more entries
            me.status, me.route = GONE, place.entry_times_s.shape[0] - 1
