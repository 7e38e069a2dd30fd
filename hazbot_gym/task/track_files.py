"""Reading recordings of walking people: a table, its description, units, frame rate and gaps.

A table (``track_formats``) may have a description beside it, a JSON file of the same name with
frame rate, unit, columns, walls, corridor, source, licence and citation. Values missing in options,
description and file are inferred if only one reading gives plausible walking, else they are
required. ``Recording.reading`` holds the used values and their sources.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_checks import (
    GUESS,
    SMALLEST_EXTENT_M,
    STILL_MPS,
    WALKING_MPS,
    median_speed,
    walking_speed,
)
from hazbot_gym.task.track_description import (
    LEAST_SCALE,
    MOST_SCALE,
    Description,
    Geometry,
    read_description,
)
from hazbot_gym.task.track_formats import Given, Table, read_table
from hazbot_gym.task.track_formats.table import Unit
from hazbot_gym.task.tracks import Corridor, Reading, Recording

_METRES: dict[Unit, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}

LONGEST_GAP_S = 0.5  # a longer gap starts a new person
FASTEST_MPS = 5.0  # maximum plausible speed; many faster steps mean a wrong unit or frame rate
MOST_STEPS = 10_000_000  # of a recording, from its first to its last
MOST_FILLED = 16  # steps for one sighting, on average: people seen every 0.5 s at 30 Hz,
ALWAYS_FILLED = 1_000_000  # or this total number


class Options(NamedTuple):
    """User options for reading a file; None: from the description or the file.

    Attributes:
        fps: Frames per second.
        units: Unit of the positions.
        columns: Names of the columns from left to right, with blanks or commas between.
        metres_per_pixel: Scale of positions in pixels.
    """

    fps: float | None = None
    units: Unit | None = None
    columns: str | None = None
    metres_per_pixel: float | None = None


class _Known(NamedTuple):
    """Values from options and description, with their source."""

    fps: float | None
    fps_from: str
    units: Unit | None
    units_from: str
    metres_per_pixel: float | None
    columns: tuple[str, ...] | None
    columns_from: str


AS_FOUND = Options()


def read_tracks(
    path: str | Path,
    *,
    fps: float | None = None,
    units: Unit | None = None,
    columns: str | None = None,
    metres_per_pixel: float | None = None,
) -> Recording:
    """Read a recording from a file.

    Args:
        path: The file; its description is beside it, with the suffix ``.json``.
        fps: See ``Options``, which override description and file.
        units: See ``Options``.
        columns: See ``Options``.
        metres_per_pixel: See ``Options``.

    Raises:
        InvalidInput: the file is missing or malformed, its rate or unit is not known, or speeds are
            implausible.
    """
    options = Options(fps, units, columns, metres_per_pixel)
    path = Path(path)
    check_options(options)
    described = read_description(path.with_suffix(".json"))
    known = _known(options, described)
    table = read_table(path, Given(known.columns, known.columns_from, known.fps))
    rate, fps_from = (known.fps, known.fps_from) if known.fps else (table.fps, table.fps_from)
    if rate is None:
        raise InvalidInput(
            f"{path.name}: fps is missing: give it, or put it into {path.stem}.json beside the file"
        )
    if not 0.0 < rate < math.inf:
        raise InvalidInput(f"{path.name}: fps must be a positive number, given {rate}")
    speeds = walking_speed(table.ids, table.frames, table.positions, rate)
    if not len(speeds):
        raise InvalidInput(f"{path.name}: no person is recorded in more than one frame")
    unit, metres, unit_from = _unit(path, table, known, speeds)
    speed = median_speed(speeds * metres)
    _check_walking(path.name, table, rate, unit, metres, speed)
    notes = list(table.notes)
    if table.fps and abs(rate / table.fps - 1.0) > 0.01:
        notes.append(f"fps is {rate:g} ({fps_from}), but its {table.fps_from} says {table.fps:g}")
    reading = Reading(
        *(table.form, table.form_from, unit, unit_from, rate, fps_from, speed, tuple(notes))
    )
    return _record(path, table._replace(positions=table.positions * metres), reading, described)


# --- columns, unit and rate ----------------------------------------------------------------------


def check_options(options: Options) -> None:
    """Reject invalid options.

    Raises:
        InvalidInput: names the option.
    """
    for name in ("fps", "metres_per_pixel"):
        value = getattr(options, name)
        if value is not None and not LEAST_SCALE <= value <= MOST_SCALE:
            allowed = f"a positive number, {LEAST_SCALE:g} to {MOST_SCALE:g}"
            raise InvalidInput(f"{name}: given {value}, allowed is {allowed}")
    if options.units is not None and options.units not in (*_METRES, "px"):
        allowed = ", ".join((*_METRES, "px"))
        raise InvalidInput(f"units: given {options.units!r}, allowed are {allowed}")


def _known(options: Options, described: Description) -> _Known:
    columns = options.columns if options.columns is not None else described.columns
    words = columns.replace(",", " ").split() if isinstance(columns, str) else columns
    return _Known(
        fps=options.fps or described.fps,
        fps_from="option" if options.fps else "json",
        units=options.units or described.units,
        units_from="option" if options.units else "json",
        metres_per_pixel=options.metres_per_pixel or described.metres_per_pixel,
        columns=None if words is None else tuple(words),
        columns_from="option" if options.columns is not None else "json",
    )


def _unit(path: Path, table: Table, known: _Known, speeds: Floats) -> tuple[Unit, float, str]:
    """Return the unit, its size in metres, and its source."""
    unit, unit_from = table.unit, table.unit_from
    if known.units:
        unit, unit_from = known.units, known.units_from
    scale = known.metres_per_pixel
    if scale is not None and unit in (None, "px"):
        return "px", scale, unit_from or "scale"
    if scale is not None:
        fault = f"metres_per_pixel is given, but units are {unit} ({unit_from})"
        raise InvalidInput(f"{path.name}: {fault}")
    if unit == "px":
        raise InvalidInput(
            f"{path.name}: positions are in pixels: give metres_per_pixel, or put "
            f"it into {path.stem}.json beside the file"
        )
    if unit is not None:
        return unit, _METRES[unit], unit_from
    low, high = WALKING_MPS
    extent = float(np.ptp(table.positions, axis=0).max())
    for unit, metres in _METRES.items():
        is_walking = low <= median_speed(speeds * metres) <= high
        if is_walking and extent * metres >= SMALLEST_EXTENT_M:
            return unit, metres, GUESS
    stamps = (
        ""
        if table.fps_from != "time column"
        else (", or its time stamps are not seconds: say so with columns, such as 'time_ms id x y'")
    )
    walked = ", ".join(f"{median_speed(speeds * m):.3g} m/s in {u}" for u, m in _METRES.items())
    raise InvalidInput(
        f"{path.name}: unit not recognized: people would walk at {walked}, or all within "
        f"{SMALLEST_EXTENT_M:g} m; fps or columns are wrong, or give units{stamps}"
    )


def _check_walking(
    name: str, table: Table, fps: float, unit: Unit, metres: float, speed_mps: float
) -> None:
    """Reject a recording without walking, or with one step in ten faster than plausible."""
    same = np.diff(table.ids) == 0
    steps = np.hypot(*np.diff(table.positions, axis=0)[same].T) * metres
    fast = float(np.percentile(steps * fps / np.diff(table.frames)[same], 90))
    if fast > FASTEST_MPS:
        raise InvalidInput(
            f"{name}: one step in ten is faster than {fast:.0f} m/s: "
            f"fps {fps:g} or unit {unit} is wrong, or id and frame are swapped"
        )
    if speed_mps < STILL_MPS:
        raise InvalidInput(
            f"{name}: no person walks: the median speed is {speed_mps:.2g} m/s; "
            f"fps {fps:g} or unit {unit} is wrong, or people only stand"
        )


# --- time and gaps -------------------------------------------------------------------------------


def _record(path: Path, table: Table, reading: Reading, described: Description) -> Recording:
    """Convert the sightings to equal time steps, person by person."""
    frames = table.frames - table.frames.min()
    frame_step = int(np.gcd.reduce(frames))
    dt_s = frame_step / reading.fps
    steps = frames // frame_step
    if steps.max() >= MOST_STEPS:
        raise InvalidInput(
            f"{path.name}: it lasts {steps.max() * dt_s:.3g} s in {steps.max() + 1} steps, allowed "
            f"are {MOST_STEPS}: a frame number or fps is wrong"
        )
    longest_gap = max(1, int(LONGEST_GAP_S / dt_s + 1e-9))
    is_new = (np.diff(table.ids) != 0) | (np.diff(steps) > longest_gap)
    starts = np.flatnonzero(np.append(True, is_new))
    ends = np.append(starts[1:], len(steps)) - 1
    lengths = steps[ends] - steps[starts] + 1
    if lengths.sum() > max(MOST_FILLED * len(steps), ALWAYS_FILLED):
        raise InvalidInput(
            f"{path.name}: {len(steps)} sightings would become {lengths.sum()}: frames have no "
            f"step in common but {frame_step}; put them on a clock, or name a column of time"
        )
    place = described.geometry
    walls = np.array(place.walls, dtype=np.float64).reshape(-1, 4)
    return Recording(
        name=described.name or path.stem,
        dt_s=dt_s,
        ids=table.ids[starts],
        first_steps=steps[starts],
        lengths=lengths,
        positions=_fill_gaps(steps, table.positions, starts, ends),
        walls=walls if "walls" in place.model_fields_set else table.walls,
        corridor=_corridor(path.stem, place),
        source=str(described.source),
        licence=described.licence,
        citation=described.citation,
        reading=reading,
    )


def _fill_gaps(steps: Ints, positions: Floats, starts: Ints, ends: Ints) -> Floats:
    """Return positions at every step from each start to its end, by linear interpolation."""
    lengths = steps[ends] - steps[starts] + 1
    if lengths.sum() == len(steps):
        return positions
    # A single clock: each stretch is shifted behind the previous one.
    shifts = np.cumsum(lengths) - lengths - steps[starts]
    clock = steps + np.repeat(shifts, ends - starts + 1)
    wanted = np.arange(lengths.sum())
    return np.stack([np.interp(wanted, clock, axis) for axis in positions.T], axis=1)


def _corridor(stem: str, place: Geometry) -> Corridor | None:
    if place.corridor_axis is None or place.corridor_x is None or place.corridor_y is None:
        return None
    for low, high in (place.corridor_x, place.corridor_y):
        if not low < high:
            raise InvalidInput(
                f"{stem}.json: a corridor must reach from less to more: {low}, {high}"
            )
    return Corridor(place.corridor_axis, place.corridor_x, place.corridor_y)
