"""JuPedSim sqlite: ``trajectory_data(frame, id, pos_x, pos_y)``, ``metadata`` and ``geometry``.

``metadata`` holds ``fps`` and the version of the format, ``geometry`` the walkable area as WKT,
whose edges become walls. Positions are in metres.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.table import (
    MOST_BYTES,
    Table,
    UnknownFormat,
    sorted_sightings,
)
from hazbot_gym.task.track_formats.walkable import walls_of

_VERSIONS = ("1", "2", "3")


def read(path: Path) -> Table:
    """Read a file.

    Raises:
        UnknownFormat: a table or a column is missing.
        InvalidInput: the database is damaged, or a value is not a number.
        MissingExtra: shapely is not installed, and there is a geometry.
    """
    if path.stat().st_size > MOST_BYTES:
        raise InvalidInput(f"{path.name}: is larger than 256 MiB")
    try:
        database = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)
        try:
            return _read(path.name, database)
        finally:
            database.close()
    # Damaged names can be undecodable, in sqlite's error messages, too.
    except (sqlite3.Error, OverflowError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split())
        raise InvalidInput(f"{path.name}: is not a usable database ({reason})") from None


def _read(name: str, database: sqlite3.Connection) -> Table:
    # A view could compute endlessly: only tables are read.
    named = database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
    tables = {row[0] for row in named}
    columns = {row[1] for row in database.execute("PRAGMA table_info(trajectory_data)")}
    if "trajectory_data" not in tables or not {"frame", "id", "pos_x", "pos_y"} <= columns:
        raise UnknownFormat(name, "a database without trajectory_data(frame, id, pos_x, pos_y)")
    metadata = _metadata(database) if "metadata" in tables else {}
    rows = database.execute("SELECT id, frame, pos_x, pos_y FROM trajectory_data")
    try:
        table: Floats = np.fromiter(rows, dtype=np.dtype((np.float64, 4))).astype(np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"{name}: trajectory_data: a value is not a number") from None
    fps = _rate(name, metadata.get("fps"))
    version = metadata.get("version", "")
    known = f"known are {', '.join(_VERSIONS)}"
    return Table(
        *sorted_sightings(name, table[:, 0], table[:, 1], table[:, 2:]),
        form="JuPedSim",
        fps=fps,
        fps_from="metadata" if fps else "",
        unit="m",
        unit_from="format",
        walls=_walls(name, database) if "geometry" in tables else np.zeros((0, 4)),
        notes=() if version in _VERSIONS else (f"version {version!r} of the format; {known}",),
    )


def _metadata(database: sqlite3.Connection) -> dict[str, str]:
    rows = database.execute("SELECT key, value FROM metadata")
    return {str(key): str(value) for key, value in rows}


def _rate(name: str, value: str | None) -> float | None:
    try:
        return float(value) if value else None
    except ValueError:
        raise InvalidInput(f"{name}: metadata: fps must be a number, given {value!r}") from None


def _walls(name: str, database: sqlite3.Connection) -> Floats:
    areas = [row[0] for row in database.execute("SELECT wkt FROM geometry")]
    return walls_of(name, areas)
