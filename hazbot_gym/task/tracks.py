"""Recordings of walking people, and their positions on any clock.

A recording is ragged: every person is seen for a stretch of consecutive steps. Time zero is the
recording's first step. Files are read in ``track_files``, counted in ``track_statistics``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints

_ROUNDING = 1e-9  # of a step, by which a clock's multiples may miss a recording's


class Corridor(NamedTuple):
    """A straight corridor along a coordinate axis."""

    axis: Literal["x", "y"]  # the long one
    x_m: tuple[float, float]
    y_m: tuple[float, float]


class Reading(NamedTuple):
    """With what a recording was read, and where each came from.

    Attributes:
        form: Format of the file, or its columns.
        form_from: Where the order of the columns comes from.
        unit: Unit of the positions in the file.
        unit_from: Where it comes from.
        fps: Frames per second.
        fps_from: Where they come from.
        speed_mps: Median walking speed [m/s].
        notes: What was left out or contradicts, a sentence each.
    """

    form: str
    form_from: str
    unit: str
    unit_from: str
    fps: float
    fps_from: str
    speed_mps: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Recording:
    """People's tracks at constant time steps.

    Attributes:
        name: What the recording is called.
        dt_s: Time step [s].
        ids: (P,) each person's number in the source; who was lost for a while comes twice.
        first_steps: (P,) step at which each person is first seen; the earliest is 0.
        lengths: (P,) number of consecutive steps for which each person is seen.
        positions: (N, 2) all persons' positions, one person after the other [m].
        walls: (W, 4) segments x1, y1, x2, y2 [m].
        corridor: Where people walk, if that is a corridor.
        source: Where the file came from.
        licence: Under which terms.
        citation: Whom to name.
        reading: With what it was read from a file.
    """

    name: str
    dt_s: float
    ids: Ints
    first_steps: Ints
    lengths: Ints
    positions: Floats
    walls: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    corridor: Corridor | None = None
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


def resample(recording: Recording, dt_s: float) -> Floats:
    """Return everybody's positions (T, P, 2) at 0, dt, 2 dt, ... [m], NaN where absent.

    Positions between two steps are interpolated linearly.
    """
    steps = int(recording.duration_s / dt_s + _ROUNDING) + 1
    return _on_clock(recording, np.arange(steps, dtype=np.float64) * dt_s)


def window(recording: Recording, t0_s: float, duration_s: float, dt_s: float) -> Floats:
    """Return positions (T, P, 2) at t0, t0 + dt, ... before t0 + duration [m], NaN where absent.

    Only people who are seen at one of these times are in it, in the recording's order.
    """
    times = t0_s + np.arange(round(duration_s / dt_s), dtype=np.float64) * dt_s
    positions = _on_clock(recording, times)
    is_seen = ~np.isnan(positions[:, :, 0]).all(axis=0)
    return positions[:, is_seen]


def _on_clock(recording: Recording, times: Floats) -> Floats:
    positions = np.full((len(times), recording.people, 2), np.nan)
    clock = times / recording.dt_s
    starts = recording.first_steps
    begins = np.searchsorted(clock, starts - _ROUNDING)
    ends = np.searchsorted(clock, starts + recording.lengths - 1 + _ROUNDING, side="right")
    for i, track in enumerate(recording.tracks()):
        own = clock[begins[i] : ends[i]] - starts[i]
        steps = np.arange(len(track))
        positions[begins[i] : ends[i], i, 0] = np.interp(own, steps, track[:, 0])
        positions[begins[i] : ends[i], i, 1] = np.interp(own, steps, track[:, 1])
    return positions
