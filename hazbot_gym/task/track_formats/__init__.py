"""Formats of track files, one reader each, all giving the same table.

``text``: delimited tables, with names or without, and Stanford Drone annotations; ``trajnet``:
TrajNet++ ndjson; ``jupedsim``: JuPedSim sqlite; ``juelich``: hdf5 of the Juelich archive. A file is
recognized by its first bytes, whatever its ending.
"""

from __future__ import annotations

from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats import juelich, jupedsim, text, trajnet
from hazbot_gym.task.track_formats.layout import FEWEST_CELLS, is_number, layout_of
from hazbot_gym.task.track_formats.table import NOTHING, Given, Table, UnknownFormat

ENDINGS = (".csv", ".tsv", ".txt", ".ndjson", ".sqlite", ".sqlite3", ".db", ".h5", ".hdf5")
_BINARY = ((b"SQLite format 3\0", jupedsim.read), (b"\x89HDF\r\n\x1a\n", juelich.read))


def read_table(path: Path, given: Given = NOTHING) -> Table:
    """Read the sightings of a file.

    Args:
        path: of the file.
        given: What is known about it from elsewhere.

    Raises:
        UnknownFormat: the file is in no format that is read.
        InvalidInput: the file is missing or malformed.
        MissingExtra: its reader needs a package that is not installed.
    """
    try:
        with path.open("rb") as file:
            start = file.read(4096)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    reader = next((read for magic, read in _BINARY if start.startswith(magic)), None)
    if reader is None and start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"{"):
        reader = trajnet.read
    if reader is None:
        return text.read(path, given)
    if given.columns is not None:
        raise InvalidInput(f"{path.name}: columns are given, but its format names them")
    return reader(path)


def looks_like_table(path: Path) -> bool:
    """Tell whether a text has rows of at least four cells, all but one of them numbers."""
    try:
        row = layout_of(path, at_most=1 << 16)
    except InvalidInput:
        return False
    numbers = sum(is_number(cell, row.decimal) for cell in row.row)
    return len(row.row) >= FEWEST_CELLS and numbers >= FEWEST_CELLS - 1


__all__ = ["ENDINGS", "Given", "Table", "UnknownFormat", "looks_like_table", "read_table"]
