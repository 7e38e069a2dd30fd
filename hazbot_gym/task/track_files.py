"""Reading recordings of walking people: the table, its description, units, frame rate and gaps.

A table (``track_table``) may have a description beside it, a JSON file of the same name with frame
rate, unit, walls, corridor, source, licence and citation. What the description does not say is read
from the table's comments, or recognised, or must be given.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, PositiveFloat, ValidationError

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_table import Table, has_rows_of_numbers, read_table
from hazbot_gym.task.tracks import Corridor, Recording

Unit = Literal["m", "cm", "mm"]
_METRES: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}

LONGEST_GAP_S = 0.5  # who is lost for longer comes back as somebody else
FASTEST_MPS = 5.0  # nobody walks faster; when many do, the unit or the frame rate is wrong

_FPS_IN_WORDS = re.compile(r"frame\s*rate\D*(\d+\.?\d*)", re.IGNORECASE)
_UNIT_IN_WORDS = re.compile(r"\bx\s*(?:/|\[|\(|in\b)\s*(mm|cm|m)\b", re.IGNORECASE)


class Geometry(BaseModel):
    """The place, as a description gives it [m]."""

    corridor_axis: Literal["x", "y"] | None = None
    corridor_x: tuple[float, float] | None = None
    corridor_y: tuple[float, float] | None = None
    walls: list[tuple[tuple[float, float], tuple[float, float]]] = []


class Source(BaseModel):
    """Where a table was made from."""

    repo: str = ""
    commit: str = ""
    path: str = ""
    original_file: str = ""


class Description(BaseModel):
    """What the JSON beside a table may say; other fields are left alone."""

    name: str = ""
    fps: PositiveFloat | None = None
    units: Unit | None = None
    geometry: Geometry = Geometry()
    source: str | Source = ""
    licence: str = ""
    citation: str = ""


def read_tracks(
    path: str | Path, *, fps: float | None = None, unit: Unit | None = None
) -> Recording:
    """Read a recording from a file.

    Args:
        path: The file; its description is looked for beside it, with the ending ``.json``.
        fps: Frames per second; by default what the description or a comment says.
        unit: Unit of the positions; by default what the description or the names of the columns
            say, else the largest in which people do not run.

    Raises:
        InvalidInput: the file is missing or malformed, or its frame rate is not known.
    """
    path = Path(path)
    if unit is not None and unit not in _METRES:
        raise InvalidInput(f"unit must be one of {', '.join(_METRES)}, given {unit!r}")
    table = read_table(path)
    described = read_description(path.with_suffix(".json"))
    if fps is None:
        fps = described.fps or _fps_in(table.head)
    if fps is None:
        raise InvalidInput(
            f"{path.name}: fps is missing: give it, or put it into {path.stem}.json beside the file"
        )
    if not 0.0 < fps < math.inf:
        raise InvalidInput(f"{path.name}: fps must be a positive number, given {fps}")
    metres = _in_metres(path.name, table, fps, unit or described.units or _unit_in(table.head))
    return _record(path.stem, table._replace(positions=metres), fps, described)


def find_recordings(directory: str | Path) -> list[Path]:
    """Return the recordings in a directory and those below it; a file is returned as it is.

    Every ``.csv`` is one, and every ``.txt`` with rows of numbers unless a table has the same name
    or a description names it as the original of a table: nobody is to be read twice.

    Raises:
        InvalidInput: there are none.
    """
    directory = Path(directory)
    if directory.is_file():
        return [directory]
    tables = sorted(directory.rglob("*.csv"))
    taken = {path.stem for path in tables}
    taken |= {_original(path) for path in tables}
    texts = [path for path in sorted(directory.rglob("*.txt")) if path.stem not in taken]
    found = tables + [path for path in texts if has_rows_of_numbers(path)]
    if not found:
        raise InvalidInput(f"tracks: no recordings (.csv or .txt) in {directory}")
    return found


def _original(path: Path) -> str:
    """Return the name without ending of the file from which a table was made, if known."""
    try:
        source = read_description(path.with_suffix(".json")).source
    except InvalidInput:  # whoever reads the table will be told
        return ""
    return Path(source.original_file).stem if isinstance(source, Source) else ""


def read_description(path: Path) -> Description:
    """Read a description; an empty one if there is no such file.

    Raises:
        InvalidInput: the file is not JSON, or a field is not usable.
    """
    if not path.exists():
        return Description()
    try:
        return Description.model_validate_json(path.read_bytes())
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        words = [word for word in (path.name, field, first["msg"]) if word]
        raise InvalidInput(": ".join(words)) from None


# --- units and time ------------------------------------------------------------------------------


def _fps_in(head: str) -> float | None:
    found = _FPS_IN_WORDS.search(head)
    return float(found[1]) if found else None


def _unit_in(head: str) -> str | None:
    found = _UNIT_IN_WORDS.search(head)
    return found[1].lower() if found else None


def _in_metres(name: str, table: Table, fps: float, unit: str | None) -> Floats:
    """Return the positions in metres; nine of ten steps must be slower than nobody walks."""
    same = np.diff(table.ids) == 0
    steps = np.hypot(*np.diff(table.positions, axis=0)[same].T)
    if not steps.size:
        raise InvalidInput(f"{name}: nobody is seen in more than one frame")
    fast = float(np.percentile(steps * fps / np.diff(table.frames)[same], 90))
    for metres in [_METRES[unit]] if unit else _METRES.values():
        if fast * metres <= FASTEST_MPS:
            return table.positions * metres
    raise InvalidInput(
        f"{name}: one step in ten is faster than {fast * metres:.0f} m/s: "
        f"fps {fps:g} or unit {unit or 'mm'} is wrong, or id and frame are swapped"
    )


def _record(stem: str, table: Table, fps: float, described: Description) -> Recording:
    """Put the sightings on equal time steps, person by person."""
    frames = table.frames - table.frames.min()
    frame_step = int(np.gcd.reduce(frames))
    dt_s = frame_step / fps
    steps = frames // frame_step
    longest_gap = max(1, int(LONGEST_GAP_S / dt_s + 1e-9))
    is_new = (np.diff(table.ids) != 0) | (np.diff(steps) > longest_gap)
    starts = np.flatnonzero(np.append(True, is_new))
    ends = np.append(starts[1:], len(steps)) - 1
    place = described.geometry
    return Recording(
        name=described.name or stem,
        dt_s=dt_s,
        ids=table.ids[starts],
        first_steps=steps[starts],
        lengths=steps[ends] - steps[starts] + 1,
        positions=_fill_gaps(steps, table.positions, starts, ends),
        walls=np.array(place.walls, dtype=np.float64).reshape(-1, 4),
        corridor=_corridor(stem, place),
        source=_source_in_words(described.source),
        licence=described.licence,
        citation=described.citation,
    )


def _fill_gaps(steps: Ints, positions: Floats, starts: Ints, ends: Ints) -> Floats:
    """Return positions at every step from each start to its end, by linear interpolation."""
    lengths = steps[ends] - steps[starts] + 1
    if lengths.sum() == len(steps):
        return positions
    # One clock for all: each stretch is moved behind the one before it.
    shifts = np.cumsum(lengths) - lengths - steps[starts]
    clock = steps + np.repeat(shifts, ends - starts + 1)
    wanted = np.arange(lengths.sum())
    return np.stack([np.interp(wanted, clock, axis) for axis in positions.T], axis=1)


def _source_in_words(source: str | Source) -> str:
    if isinstance(source, str):
        return source
    return " ".join(part for part in (source.repo, source.commit, source.path) if part)


def _corridor(stem: str, place: Geometry) -> Corridor | None:
    if place.corridor_axis is None or place.corridor_x is None or place.corridor_y is None:
        return None
    for low, high in (place.corridor_x, place.corridor_y):
        if not low < high:
            raise InvalidInput(
                f"{stem}.json: a corridor must reach from less to more: {low}, {high}"
            )
    return Corridor(place.corridor_axis, place.corridor_x, place.corridor_y)
