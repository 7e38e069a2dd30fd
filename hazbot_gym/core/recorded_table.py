"""Recordings of people as arrays, and the lookup of a person at a step, for kernels.

Positions are kept person by person, so that memory goes with the number of sightings. A slot serves
consecutive people: a world needs only as many records as people present at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import Floats, Ints


class RecordedTable(NamedTuple):
    """R recordings on the social clock, each with the places of two ways through it, or of one."""

    dt_s: float  # the social period
    recording_of_place: Ints  # (L,)
    ways: Ints  # (R, 2) places of each recording, the same twice if there is one
    counts: Ints  # (R,) steps of each recording
    slots: Ints  # (R, S + 1) first stay in each slot, and the stay after the last
    firsts: Ints  # (V,) step at which each stay begins, in order within a slot
    offsets: Ints  # (V + 1,) row of each stay's first position
    positions: Floats  # (N, 2) one stay after the other [m]


class Stretch(NamedTuple):
    """The part of a recording that an episode replays."""

    start: int  # step of the recording at which the episode begins
    steps: int  # from there to the recording's end
    slots: Ints  # (S + 1,) and below as in ``RecordedTable``
    firsts: Ints
    offsets: Ints
    positions: Floats


NO_RECORDING = RecordedTable(
    dt_s=1.0,
    recording_of_place=np.zeros(1, np.int64),
    ways=np.zeros((1, 2), np.int64),
    counts=np.zeros(1, np.int64),
    slots=np.zeros((1, 1), np.int64),
    firsts=np.zeros(0, np.int64),
    offsets=np.zeros(1, np.int64),
    positions=np.zeros((0, 2)),
)


@scalar
def stretch_of(table: RecordedTable, place: int, start: int) -> Stretch:
    """Return a place's recording from a step on, as views into the table."""
    which = table.recording_of_place[place]
    return Stretch(
        start,
        table.counts[which] - start,
        table.slots[which],
        table.firsts,
        table.offsets,
        table.positions,
    )


@scalar
def stay_at(stretch: Stretch, slot: int, step: int) -> int:
    """Return the last stay in a slot that has begun by a step; -1 if none has."""
    now, first = stretch.start + step, stretch.slots[slot]
    low, high = first, stretch.slots[slot + 1]
    while low < high:
        middle = (low + high) // 2
        if stretch.firsts[middle] <= now:
            low = middle + 1
        else:
            high = middle
    return -1 if low == first else low - 1


@scalar
def rows_of(stretch: Stretch, stay: int, step: int) -> tuple[int, int]:
    """Return the row of a stay's position at a step, and the row after its last.

    The person is absent if the first is not below the second.
    """
    if stay < 0:
        return 0, 0
    now = stretch.start + step
    return stretch.offsets[stay] + now - stretch.firsts[stay], stretch.offsets[stay + 1]


@scalar
def rows_from(stretch: Stretch, slot: int, step: int) -> tuple[int, int]:
    """Return ``rows_of`` the stay in a slot at a step."""
    return rows_of(stretch, stay_at(stretch, slot, step), step)


NO_STRETCH = stretch_of(NO_RECORDING, 0, 0)
