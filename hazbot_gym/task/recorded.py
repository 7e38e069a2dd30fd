"""Real people in the robot's way: stretches of recordings, replayed, or used to seed walkers.

Replayed people walk as recorded, whatever the robot does (only not through it). Seeding takes from
each person only when and where it comes in, how fast it walks and where it leaves; the social-force
model does the rest, so that these people do answer to the robot.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.entries import REST_S, seat
from hazbot_gym.core.geometry import path_length
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.noise import SCENARIO, uniform4
from hazbot_gym.core.place_table import PlaceTable
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
from hazbot_gym.task.place_data import PathData, PlaceData, build_place, pad_routes
from hazbot_gym.task.replay_place import replay_frame
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_folders import find_recordings, load_tracks
from hazbot_gym.task.track_statistics import Entries, entries
from hazbot_gym.task.tracks import Recording, resample

ATTEMPTS = 8  # to find a moment at which nobody stands at the robot's start
START_ROOM_M = 1.5  # free distance to people at the start
SHORTEST_WAY_M = 1.0  # from entry to exit, of people who seed walkers
EMPTY_STEPS = 4  # between two people in a slot, so that every decision can tell them apart


class RecordedTable(NamedTuple):
    """Recordings as arrays, one after the other; places 2 r and 2 r + 1 are the ways through r."""

    dt_s: float  # the social period, on which positions are given
    starts: npt.NDArray[np.int64]  # (recordings,) first row of each in ``positions``
    counts: npt.NDArray[np.int64]  # (recordings,) number of rows
    positions: Floats  # (rows, S, 2) people in slots [m], NaN where a slot is empty


def load_recordings(tracks: str | None) -> list[Recording]:
    """Return the recordings of a file or folder; without one, the package's own synthetic one.

    Raises:
        InvalidInput: There is no such file or folder, or a file in it cannot be used.
    """
    if tracks is None:
        return [synthetic_recording()]
    return load_tracks(tracks)


def tracks_files(tracks: str | None) -> list[Path]:
    """Return the files that ``load_recordings`` reads: tables, and the descriptions beside them.

    Raises:
        InvalidInput: There is no such file or folder, or no recording in it.
    """
    if tracks is None:
        return []
    tables = find_recordings(tracks)
    descriptions = [table.with_suffix(".json") for table in tables]
    return tables + [path for path in descriptions if path.exists() and path not in tables]


def recorded_places(recordings: list[Recording], *, with_entries: bool) -> list[Place]:
    """Return the two ways through each recording; routes are the people's own if asked for."""
    places = []
    for recording in recordings:
        for is_reversed in (False, True):
            place = _place(recording, is_reversed=is_reversed)
            places.append(_with_entry_routes(place, recording) if with_entries else place)
    return places


def recorded_table(recordings: list[Recording], dt_s: float) -> RecordedTable:
    """Return the recordings as arrays on a clock [s]."""
    packed = [_in_slots(resample(recording, dt_s)) for recording in recordings]
    counts = np.array([len(positions) for positions in packed])
    slots = max(positions.shape[1] for positions in packed)
    rows = np.full((int(counts.sum()), slots, 2), np.nan)
    starts = np.cumsum(counts) - counts
    for start, positions in zip(starts, packed, strict=True):
        rows[start : start + len(positions), : positions.shape[1]] = positions
    return RecordedTable(dt_s, starts, counts, rows)


def most_at_once(places: list[Place], duration_s: float) -> int:
    """Return for how many people there must be records at once, with room for those held up.

    Args:
        places: With entries.
        duration_s: Of an episode: nobody who comes later needs one [s].
    """
    return max(min(_together(place), _within(place, duration_s)) for place in places)


def _together(place: Place) -> int:
    """Return a half more than the most people who are in a place at once at their own speeds."""
    ways_m = place.routes[:, -1, 2]
    ends_s = np.sort(place.entry_times_s + ways_m / place.entry_speeds_mps + REST_S)
    gone = np.searchsorted(ends_s, place.entry_times_s, side="right")
    there = np.arange(1, len(ends_s) + 1) - gone
    return math.ceil(1.5 * float(there.max(initial=1)))


def _within(place: Place, duration_s: float) -> int:
    """Return how many people come in at most within a duration."""
    times_s = place.entry_times_s
    inside = np.searchsorted(times_s, times_s + duration_s) - np.arange(len(times_s))
    return int(inside.max(initial=1))


def _place(recording: Recording, *, is_reversed: bool) -> Place:
    frame = replay_frame(recording, is_reversed=is_reversed)
    points = [(float(x), float(y)) for x, y in (frame.start, frame.end)]
    walls = [(float(a), float(b), float(c), float(d)) for a, b, c, d in frame.walls]
    return build_place(PlaceData(name=recording.name, walls=walls, path=PathData(points=points)))


def _entries(recording: Recording) -> Entries:
    """Return how people come in, without those who leave where they came: theirs is no way."""
    came = entries(inside_corridor(recording))
    is_way = np.hypot(*(came.exit_points - came.entry_points).T) >= SHORTEST_WAY_M
    return Entries(*(column[is_way] for column in came))


def _with_entry_routes(place: Place, recording: Recording) -> Place:
    """Return the place with a straight route for each person, from where it came in to its exit."""
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
    """Return the recording cut to the corridor, where straight routes meet no wall."""
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
        raise InvalidInput(f"tracks: nobody in {recording.name} comes into its corridor")
    return replace(
        recording,
        ids=np.array(ids),
        first_steps=np.array(firsts),
        lengths=np.array([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
    )


def _in_slots(positions: Floats) -> Floats:
    """Return positions (T, P, 2) as (T, S, 2), where a slot serves one person after another.

    A world then needs records for as many people as are there at once, not for all who ever come.
    """
    is_there = ~np.isnan(positions[:, :, 0])
    free_from: list[int] = []
    packed = np.full_like(positions, np.nan)
    for person in np.argsort(np.argmax(is_there, axis=0), kind="stable"):
        steps = np.flatnonzero(is_there[:, person])
        if not len(steps):
            continue
        slot = next((k for k, step in enumerate(free_from) if step <= steps[0]), len(free_from))
        if slot == len(free_from):
            free_from.append(0)
        packed[steps, slot] = positions[steps, person]
        free_from[slot] = int(steps[-1]) + 1 + EMPTY_STEPS
    return packed[:, : len(free_from)]


# --- drawing -------------------------------------------------------------------------------------


@scalar
def _is_start_free(table: RecordedTable, row: int, x: float, y: float) -> bool:
    for slot in range(table.positions.shape[1]):
        dx, dy = table.positions[row, slot, 0] - x, table.positions[row, slot, 1] - y
        if dx * dx + dy * dy < START_ROOM_M * START_ROOM_M:  # false for NaN
            return False
    return True


@scalar
def draw_stretch(
    table: RecordedTable, places: PlaceTable, key: np.uint64, nominal_speed_mps: float
) -> tuple[int, int]:
    """Return which place, and which row of the positions an episode starts at.

    It leaves time for twice the drive at nominal speed, where the recording is long enough.
    """
    u_which, u_way, _, _ = uniform4(key, SCENARIO, 0, 0)
    which = min(int(u_which * table.starts.shape[0]), table.starts.shape[0] - 1)
    place = 2 * which + (1 if u_way < 0.5 else 0)
    path = places.paths[place, : places.path_counts[place]]
    needed = int(2.0 * path_length(path) / nominal_speed_mps / table.dt_s)
    latest = max(table.counts[which] - 1 - needed, 0)
    row = 0
    for attempt in range(ATTEMPTS):
        row = table.starts[which] + int(latest * uniform4(key, SCENARIO, attempt, 1)[0])
        if _is_start_free(table, row, path[0].x, path[0].y):
            break
    return place, row


@scalar
def fill_replayed(people: Records) -> None:
    """Write people who follow the slots of a recording."""
    for i in range(people.shape[0]):
        me = people[i]
        me.model, me.status, me.radius, me.route = REPLAY, WAITING, PERSON_RADIUS_M, i


@scalar
def fill_seeded(
    people: Records, place: Place, start_s: float, shares: Floats, key: np.uint64
) -> None:
    """Write social-force people who come in from a moment of a recording on, as recorded."""
    first = 0
    while first < place.entry_times_s.shape[0] and place.entry_times_s[first] < start_s:
        first += 1
    for i in range(people.shape[0]):
        me = people[i]
        me.model, me.radius = SOCIAL_FORCE, PERSON_RADIUS_M
        me.reaction = choose_reaction(uniform4(key, SCENARIO, 0, 2 + i)[0], shares)
        if first + i < place.entry_times_s.shape[0]:
            seat(me, place, first + i, start_s)
        else:  # nobody is left to come
            me.status, me.route = GONE, place.entry_times_s.shape[0] - 1
