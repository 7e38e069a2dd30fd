"""Real people in the robot's way: stretches of recordings, replayed, or used to seed walkers.

``replay`` lets everybody walk as recorded, whatever the robot does (only not through it).
``seed_people`` takes from each person only when and where it comes in, how fast it walks and where
it leaves; the social-force model does the rest, so that these people do answer to the robot.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.noise import SCENARIO, uniform4
from hazbot_gym.core.state import (
    PERSON,
    PERSON_RADIUS_M,
    REPLAY,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Records,
    records,
)
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.places import PathData, PlaceData, build_place, pad_routes
from hazbot_gym.task.replay_place import replay_frame
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_files import find_recordings, read_tracks
from hazbot_gym.task.track_statistics import entries
from hazbot_gym.task.tracks import Recording, resample

ATTEMPTS = 8  # to find a moment at which nobody stands at the robot's start
EMPTY_STEPS = 4  # between two people in a slot, so that every decision can tell them apart
START_ROOM_M = 1.5  # free distance to people at the start


class Stretch(NamedTuple):
    """A part of a recording, and a way for the robot through it."""

    recording: Recording
    place: Place
    start_s: float  # the recording's time at the episode's start


class Recordings:
    """The recordings of a file or folder; without one, the package's own synthetic recording."""

    def __init__(self, tracks: str | None) -> None:
        """Read everything; raises InvalidInput if a file cannot be used or there is none."""
        self._recordings = [synthetic_recording()] if tracks is None else _read(Path(tracks))
        self._places = [
            (_place(recording, is_reversed=False), _place(recording, is_reversed=True))
            for recording in self._recordings
        ]

    def choose(self, key: int, nominal_speed_mps: float) -> Stretch:
        """Return the stretch of a key: which recording, which way, and from when on."""
        u_which, u_way, _, _ = uniform4(np.uint64(key), SCENARIO, 0, 0)
        i = min(int(u_which * len(self._recordings)), len(self._recordings) - 1)
        recording, place = self._recordings[i], self._places[i][int(u_way < 0.5)]
        length_m = float(place.path["s"][-1] + place.path["length"][-1])
        latest_s = max(recording.duration_s - 2.0 * length_m / nominal_speed_mps, 0.0)
        for attempt in range(ATTEMPTS):
            start_s = latest_s * uniform4(np.uint64(key), SCENARIO, attempt, 1)[0]
            if _is_start_free(recording, place, start_s):
                break
        return Stretch(recording, place, start_s)


def _read(path: Path) -> list[Recording]:
    if path.is_dir():
        return [read_tracks(file) for file in find_recordings(path)]
    if not path.exists():
        raise InvalidInput(f"tracks: given {str(path)!r}, there is no such file or folder")
    return [read_tracks(path)]


def _place(recording: Recording, *, is_reversed: bool) -> Place:
    frame = replay_frame(recording, is_reversed=is_reversed)
    path = PathData(points=[(float(x), float(y)) for x, y in (frame.start, frame.end)])
    walls = [tuple(float(v) for v in wall) for wall in frame.walls]
    return build_place(
        PlaceData.model_validate({"name": recording.name, "walls": walls, "path": path})
    )


def _is_start_free(recording: Recording, place: Place, start_s: float) -> bool:
    positions = _on_clock(recording, 0.1)
    row = positions[min(int(start_s / 0.1), len(positions) - 1)]
    start = np.array([place.path["x"][0], place.path["y"][0]])
    distance = np.hypot(*(row - start).T)
    return not bool(np.any(distance < START_ROOM_M))  # comparisons with NaN are false


@functools.lru_cache(maxsize=32)
def _on_clock(recording: Recording, dt_s: float) -> Floats:
    return resample(recording, dt_s)


def replay(stretch: Stretch, duration_s: float, dt_s: float) -> tuple[Records, Floats]:
    """Return people and their positions (T, P, 2) from the stretch's start on, for at most a duration."""
    positions = _in_slots(stretch.recording, dt_s)
    first = round(stretch.start_s / dt_s)
    part = positions[first : first + round(duration_s / dt_s) + 2]
    people = records(PERSON, part.shape[1])
    people["model"], people["status"], people["radius"] = REPLAY, WAITING, PERSON_RADIUS_M
    people["route"] = np.arange(part.shape[1])
    return people, part


@functools.lru_cache(maxsize=32)
def _in_slots(recording: Recording, dt_s: float) -> Floats:
    """Return positions (T, S, 2) in which a slot serves one person after another, NaN in between.

    A world then needs records for as many people as are there at once, not for all who ever come.
    """
    positions = _on_clock(recording, dt_s)
    is_there = ~np.isnan(positions[:, :, 0])
    free_from: list[int] = []
    slots: list[list[int]] = []
    for person in np.argsort(np.argmax(is_there, axis=0), kind="stable"):
        steps = np.flatnonzero(is_there[:, person])
        if not len(steps):
            continue
        slot = next((k for k, step in enumerate(free_from) if step < steps[0]), len(slots))
        if slot == len(slots):
            slots.append([])
            free_from.append(0)
        slots[slot].append(int(person))
        free_from[slot] = int(steps[-1]) + EMPTY_STEPS
    packed = np.full((len(positions), len(slots), 2), np.nan)
    for k, members in enumerate(slots):
        for person in members:
            packed[is_there[:, person], k] = positions[is_there[:, person], person]
    return packed


def seed_people(
    stretch: Stretch, duration_s: float, reaction_shares: tuple[float, ...], key: int
) -> tuple[Records, Floats]:
    """Return social-force people who enter as recorded, and their routes (P, 2, 3)."""
    came = entries(_inside_corridor(stretch.recording))
    enters_s = came.times_s - stretch.start_s
    chosen = np.flatnonzero((enters_s >= 0.0) & (enters_s < duration_s))
    people = records(PERSON, len(chosen))
    people["model"], people["status"], people["radius"] = SOCIAL_FORCE, WAITING, PERSON_RADIUS_M
    people["route"] = np.arange(len(chosen))
    people["enters_s"] = enters_s[chosen]
    people["x"], people["y"] = came.entry_points[chosen].T
    people["desired_speed"] = came.speeds_mps[chosen]
    shares = np.cumsum(np.array(reaction_shares) / sum(reaction_shares))
    draws = [uniform4(np.uint64(key), SCENARIO, 0, 2 + i)[0] for i in range(len(chosen))]
    people["reaction"] = np.minimum(np.searchsorted(shares, draws, side="right"), len(shares) - 1)
    ends = [np.stack([came.entry_points[i], came.exit_points[i]]) for i in chosen]
    return people, pad_routes(ends) if ends else np.zeros((0, 2, 3))


@functools.lru_cache(maxsize=32)
def _inside_corridor(recording: Recording) -> Recording:
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
    return replace(
        recording,
        ids=np.array(ids),
        first_steps=np.array(firsts),
        lengths=np.array([len(track) for track in tracks]),
        positions=np.concatenate(tracks),
    )
