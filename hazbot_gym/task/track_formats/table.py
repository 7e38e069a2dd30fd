"""Table of sightings, returned by every reader, and its options.

Checks that hold for all formats are here: finite numbers, whole ids and frames, one sighting of a
person in a frame.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput

Unit = Literal["m", "cm", "mm", "px"]

MOST_BYTES = 256 << 20  # of a file: a reader needs about ten times as much memory
LARGEST_WHOLE = 2**53  # ids and frames are read as float64
LARGEST_POSITION = 1e9  # in any unit
MOST_WALLS = 5000  # every step of a simulation looks at each of them
NO_WALLS: Floats = np.zeros((0, 4))


READ = (
    "tables with columns named id, frame or time, x and y; without names 'id frame x y [z]', "
    "'frame id x y [vx vy]' and obsmat; TrajNet++ .ndjson; JuPedSim .sqlite; Juelich .h5; "
    "Stanford Drone annotations"
)


class UnknownFormat(InvalidInput):
    """A file has no supported format."""

    def __init__(self, name: str, what: str) -> None:
        super().__init__(f"{name}: unknown format: {what}; read are {READ}")


class Given(NamedTuple):
    """Values from options and description; None if not given.

    Attributes:
        columns: Names of the columns, from left to right.
        columns_from: Source of the names.
        fps: Frames per second, for time stamps without a rate of their own.
    """

    columns: tuple[str, ...] | None = None
    columns_from: str = ""
    fps: float | None = None


NOTHING = Given()


class Table(NamedTuple):
    """Sightings sorted by person and frame.

    Attributes:
        ids: (N,) number of the person.
        frames: (N,) number of the frame.
        positions: (N, 2) in the file's unit.
        form: Name of the format, with the order of the columns where it has one.
        form_from: Source of the order.
        fps: Frames per second, if in the file.
        fps_from: Source of the rate.
        unit: Unit of the positions, if the file or its format says so.
        unit_from: Source of the unit.
        walls: (W, 4) segments x1, y1, x2, y2, in metres.
        notes: One sentence per omission.
    """

    ids: Ints
    frames: Ints
    positions: Floats
    form: str
    form_from: str = "format"
    fps: float | None = None
    fps_from: str = ""
    unit: Unit | None = None
    unit_from: str = ""
    walls: Floats = NO_WALLS
    notes: tuple[str, ...] = ()


def sorted_sightings(
    name: str,
    ids: Floats,
    frames: Floats,
    positions: Floats,
    place_of: Callable[[int], str] = "row {}".format,
) -> tuple[Ints, Ints, Floats]:
    """Return ids, frames and positions sorted by person and frame.

    Args:
        name: of the file.
        ids: (N,) number of the person.
        frames: (N,) number of the frame.
        positions: (N, 2).
        place_of: Returns the location of row i in the file.

    Raises:
        InvalidInput: a number cannot be used, or a person is seen twice in a frame.
    """
    if not len(ids):
        raise InvalidInput(f"{name}: is empty, there is no position in it")
    check_numbers(name, ids, frames, positions, place_of)
    order = np.lexsort((frames, ids))
    people, times = ids[order].astype(np.int64), frames[order].astype(np.int64)
    is_again = (np.diff(people) == 0) & (np.diff(times) == 0)
    if is_again.any():
        place = place_of(int(order[1:][is_again].min()))
        raise InvalidInput(f"{name}: {place}: this person was already seen in this frame")
    return people, times, positions[order]


def check_numbers(
    name: str, ids: Floats, frames: Floats, values: Floats, place_of: Callable[[int], str]
) -> None:
    """Reject ids and frames that are not whole, and values (N, k) out of bounds.

    Raises:
        InvalidInput: names the first location.
    """
    whole = np.column_stack([ids, frames])
    with np.errstate(invalid="ignore"):
        faults = (
            ("a cell is not a finite number", ~np.isfinite(whole)),
            ("a cell is not a finite number", ~np.isfinite(values)),
            ("id and frame must be whole numbers", whole % 1.0 != 0.0),
            (f"id and frame must be at most {LARGEST_WHOLE}", np.abs(whole) > LARGEST_WHOLE),
            ("a position beyond 1e9", np.abs(values) > LARGEST_POSITION),
        )
    for fault, is_bad in faults:
        if is_bad.any():
            row = int(np.argmax(is_bad.any(axis=1)))
            raise InvalidInput(f"{name}: {place_of(row)}: {fault}")
