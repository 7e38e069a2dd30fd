"""Recordings of walking people, and their positions on any clock.

A recording is ragged: every person is seen for a stretch of consecutive steps. Time zero is the
recording's first step. Files are read in ``track_files``, counted in ``track_statistics``.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints

_ROUNDING = 1e-9  # tolerance of clock multiples, in steps


class Corridor(NamedTuple):
    """A straight corridor along a coordinate axis."""

    axis: Literal["x", "y"]  # the long one
    x_m: tuple[float, float]
    y_m: tuple[float, float]


class Reading(NamedTuple):
    """Reading parameters of a recording, with their sources.

    Attributes:
        form: Format of the file, or its columns.
        form_from: Source of the column order.
        unit: Unit of the positions in the file.
        unit_from: Source of the unit.
        fps: Frames per second.
        fps_from: Source of the rate.
        speed_mps: Median walking speed [m/s].
        notes: One sentence per omission or contradiction.
    """

    form: str
    form_from: str
    unit: str
    unit_from: str
    fps: float
    fps_from: str
    speed_mps: float
    notes: tuple[str, ...] = ()


class RecordedRobot(NamedTuple):
    """A robot that the recorded people met.

    Attributes:
        name: Kind of robot.
        radius_m: Radius of its base [m].
        scenario: Kind of encounter.
        behaviour: Its driving behavior, as named in the recording.
        scene: Session of the recording.
        positions: (T, 2) its positions, from the recording's first step on [m].
    """

    name: str
    radius_m: float
    scenario: str
    behaviour: str
    scene: str
    positions: Floats


@dataclass(frozen=True, eq=False)
class Recording:
    """People's tracks at constant time steps.

    Attributes:
        name: Name of the recording.
        dt_s: Time step [s].
        ids: (P,) each person's number in the source; a person lost for a while appears twice.
        first_steps: (P,) step at which each person is first seen; the earliest is 0.
        lengths: (P,) number of consecutive steps for which each person is seen.
        positions: (N, 2) all persons' positions, one person after the other [m].
        walls: (W, 4) segments x1, y1, x2, y2 [m].
        corridor: The corridor, if any.
        robot: The robot that the people met, if any.
        source: Origin of the file.
        licence: Terms of use.
        citation: Reference to cite.
        reading: Parameters of reading the file.
    """

    name: str
    dt_s: float
    ids: Ints
    first_steps: Ints
    lengths: Ints
    positions: Floats
    walls: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    corridor: Corridor | None = None
    robot: RecordedRobot | None = None
    source: str = ""
    licence: str = ""
    citation: str = ""
    reading: Reading | None = None

    @property
    def people(self) -> int:
        """Number of people."""
        return len(self.ids)

    @property
    def offsets(self) -> Ints:
        """(P,) row of ``positions`` at which each person starts."""
        return np.cumsum(self.lengths) - self.lengths

    @property
    def duration_s(self) -> float:
        """Time from the first to the last step [s]."""
        return float(np.max(self.first_steps + self.lengths) - 1) * self.dt_s

    def tracks(self) -> list[Floats]:
        """Return each person's positions (n, 2), views into ``positions`` [m]."""
        return np.split(self.positions, self.offsets[1:])


def steps_on_clock(recording: Recording, dt_s: float) -> int:
    """Return the number of times 0, dt, 2 dt, ... within the recording."""
    return int(recording.duration_s / dt_s + _ROUNDING) + 1


def resample(recording: Recording, dt_s: float) -> Recording:
    """Return the recording at the times 0, dt, 2 dt, ..., without people not seen at any of them.

    Positions between two steps are interpolated linearly.
    """
    ids, firsts, tracks = [], [], [np.zeros((0, 2))]
    last = steps_on_clock(recording, dt_s) - 1
    people = zip(recording.ids, recording.first_steps, recording.tracks(), strict=True)
    for person, start, track in people:
        first, positions = _on_clock(track, start, recording.dt_s, dt_s, last)
        if len(positions):
            ids.append(person)
            firsts.append(first)
            tracks.append(positions)
    return replace(
        recording,
        dt_s=dt_s,
        ids=np.array(ids, np.int64),
        first_steps=np.array(firsts, np.int64),
        lengths=np.array([len(track) for track in tracks[1:]], np.int64),
        positions=np.concatenate(tracks),
    )


def _on_clock(
    track: Floats, start: int, own_dt_s: float, dt_s: float, last: int
) -> tuple[int, Floats]:
    """Return a person's first step on another clock, and its positions from there on."""
    ratio, end = own_dt_s / dt_s, start + len(track) - 1
    earliest = max(int((start - 1) * ratio), 0)
    latest = min(int((end + 1) * ratio) + 1, last)
    clock = np.arange(earliest, latest + 1) * dt_s / own_dt_s
    begin = int(np.searchsorted(clock, start - _ROUNDING))
    own = clock[begin : np.searchsorted(clock, end + _ROUNDING, side="right")] - start
    known = np.arange(len(track))
    return earliest + begin, np.stack([np.interp(own, known, axis) for axis in track.T], axis=1)
