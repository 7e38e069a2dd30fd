"""TrajNet++ ndjson: a JSON object on each line, a scene or a sighting.

    {"scene": {"id": 0, "p": 254, "s": 10238, "e": 10358, "fps": 2.5, "tag": 2}}
    {"track": {"f": 10238, "p": 248, "x": 13.2, "y": 5.85}}

Positions are in metres. ``fps`` counts rows, not numbers of frames: these may go up in steps (6 in
the line above). Rows with a ``prediction_number`` were predicted, not recorded, and are left out.
"""

from __future__ import annotations

import json
from array import array
from pathlib import Path

import numpy as np

from hazbot_gym.core.state import Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.table import (
    MOST_BYTES,
    Table,
    UnknownFormat,
    sorted_sightings,
)
from hazbot_gym.utils.json_object import JsonObject

_KEYS = ("p", "f", "x", "y")


def read(path: Path) -> Table:
    """Read a file.

    Raises:
        UnknownFormat: a line is neither a scene nor a sighting.
        InvalidInput: a line is not JSON, or the scenes have different rates.
    """
    cells, lines, predicted = array("d"), array("q"), 0
    rates: dict[str, object] = {}  # by repr, since a value may be anything
    if path.stat().st_size > MOST_BYTES:
        raise InvalidInput(f"{path.name}: is larger than 256 MiB")
    with path.open("rb") as file:
        for number, line in enumerate(file, 1):
            if not line.strip():
                continue
            row = _row(path.name, number, line)
            if "scene" in row:
                rates[repr(row["scene"].get("fps"))] = row["scene"].get("fps")
            elif "prediction_number" in row["track"]:
                predicted += 1
            else:
                cells.extend(_numbers(path.name, number, row["track"]))
                lines.append(number)
    table = np.frombuffer(cells, dtype=np.float64).reshape(-1, len(_KEYS))
    ids, frames, positions = sorted_sightings(
        path.name, table[:, 0], table[:, 1], table[:, 2:], lambda row: f"line {lines[row]}"
    )
    fps = _rate(path.name, rates, ids, frames)
    return Table(
        *(ids, frames, positions, "TrajNet++"),
        fps=fps,
        fps_from="scenes" if fps else "",
        unit="m",
        unit_from="format",
        notes=(f"{predicted} predicted positions are left out",) if predicted else (),
    )


def _row(name: str, number: int, line: bytes) -> dict[str, dict[str, object]]:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        raise InvalidInput(f"{name}: line {number}: is not JSON") from None
    for kind in ("scene", "track"):
        if isinstance(row, dict) and isinstance(row.get(kind), dict):
            return {kind: row[kind]}
    raise UnknownFormat(name, f"line {number} is neither a scene nor a track of TrajNet++")


def _numbers(name: str, number: int, track: JsonObject) -> list[float]:
    values = [track.get(key) for key in _KEYS]
    for key, value in zip(_KEYS, values, strict=True):
        if isinstance(value, bool) or not isinstance(value, int | float):
            fault = f"{key} must be a number, given {repr(value)[:40]}"
            raise InvalidInput(f"{name}: line {number}: {fault}")
    try:
        return [float(value) for value in values if value is not None]
    except OverflowError:
        raise InvalidInput(f"{name}: line {number}: a number is too large") from None


def _rate(name: str, rates: dict[str, object], ids: Ints, frames: Ints) -> float | None:
    """Return the frames per second: rows per second times the frames from row to row."""
    rates.pop("None", None)
    if not rates:
        return None
    rate = next(iter(rates.values()))
    if len(rates) > 1 or isinstance(rate, bool) or not isinstance(rate, int | float):
        told = ", ".join(each[:20] for each in sorted(rates)[:3])
        raise InvalidInput(f"{name}: fps of the scenes must be one number, given {told}")
    steps = np.diff(frames)[np.diff(ids) == 0]
    return float(rate) * float(np.median(steps)) if len(steps) else None
