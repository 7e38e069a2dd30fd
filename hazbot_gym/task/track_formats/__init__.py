"""Formats of track files, one reader each, all giving the same table.

``text``: delimited tables, with names or without, and Stanford Drone annotations; ``trajnet``:
TrajNet++ ndjson; ``jupedsim``: JuPedSim sqlite; ``juelich``: hdf5 of the Juelich archive. A file is
recognized by its first bytes, not by its suffix.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats import juelich, jupedsim, text, trajnet
from hazbot_gym.task.track_formats.layout import FEWEST_CELLS, is_number, layout_of
from hazbot_gym.task.track_formats.table import NOTHING, Given, Table, UnknownFormat

ENDINGS = (".csv", ".tsv", ".txt", ".ndjson", ".sqlite", ".sqlite3", ".db", ".h5", ".hdf5")
FEWEST_NUMBERS = 2  # of a row: x and y
_BINARY = ((b"SQLite format 3\0", jupedsim.read), (b"\x89HDF\r\n\x1a\n", juelich.read))


def read_table(path: Path, given: Given = NOTHING) -> Table:
    """Read the sightings of a file.

    Args:
        path: of the file.
        given: Values from options and description.

    Raises:
        UnknownFormat: the format is not supported.
        InvalidInput: the file is missing or malformed.
        MissingExtra: its reader needs a package that is not installed.
    """
    reader = _reader(path)
    if reader is None:
        return text.read(path, given)
    if given.columns is not None:
        raise InvalidInput(f"{path.name}: columns are given, but its format names them")
    return reader(path)


def looks_like_table(path: Path) -> bool:
    """Return True if a file may be a track table: rows with numeric cells."""
    try:
        if _reader(path) is not None:
            return True
        layout = layout_of(path, at_most=1 << 16)
    except InvalidInput:
        return False
    numbers = sum(is_number(cell, layout.decimal) for cell in layout.row)
    return len(layout.row) >= FEWEST_CELLS and numbers >= FEWEST_NUMBERS


def _reader(path: Path) -> Callable[[Path], Table] | None:
    """Return the reader for a file's first bytes, None for text."""
    try:
        with path.open("rb") as file:
            start = file.read(4096)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    if start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"{"):
        return trajnet.read
    return next((read for magic, read in _BINARY if start.startswith(magic)), None)


__all__ = ["ENDINGS", "Given", "Table", "UnknownFormat", "looks_like_table", "read_table"]
