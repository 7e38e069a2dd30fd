"""From the text of a track file to sightings: who was where in which frame.

Formats, recognised by themselves: tables whose columns are named ``id, frame, x, y`` in any order,
on the first line or in a comment; without names the Juelich archive's ``id frame x y [z]`` and the
ETH/UCY obsmat's ``frame id x z y vx vz vy``. Columns are separated by commas, semicolons or blanks,
and comments start with ``#``. Every fault is one line that says where it is.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput

_NAMES = {  # our name of a column -> what it is called in files
    "id": ("id", "persid", "personid", "person_id", "ped_id", "track_id"),
    "frame": ("frame", "fr", "frameid", "frame_id"),
    "x": ("x",),
    "y": ("y",),
}
_COLUMNS = {  # of files without names: where id, frame, x and y are, by the number of columns
    4: [0, 1, 2, 3],  # Juelich
    5: [0, 1, 2, 3],  # Juelich with the height
    8: [1, 0, 2, 4],  # ETH/UCY obsmat
}
_UNIT = re.compile(r"\s*[/\[(]\s*\w+\s*[\])]?")  # "x/cm", "x [m]", "x (m)"


class Table(NamedTuple):
    """Sightings sorted by person and frame.

    Attributes:
        head: Comments and the line of names, one a line.
        ids: (N,) who.
        frames: (N,) when.
        positions: (N, 2) where, in the file's unit.
    """

    head: str
    ids: Ints
    frames: Ints
    positions: Floats


class _Text(NamedTuple):
    """The lines of a file, sorted out."""

    name: str
    comments: list[str]
    header: str | None  # the line of names, if there is one
    rows: list[str]
    numbers: list[int]  # of the rows in the file
    separator: str | None  # None: blanks
    width: int  # cells in the first row


def read_table(path: Path) -> Table:
    """Read the sightings of a file.

    Raises:
        InvalidInput: the file is missing or malformed.
    """
    text = _sort_lines(path)
    cells = _parse(text)[:, _columns(text)]
    is_odd = ~np.all(np.isfinite(cells), axis=1)
    _refuse(text, is_odd, "a cell is not a finite number")
    is_fraction = np.any(cells[:, :2] % 1.0 != 0.0, axis=1)
    _refuse(text, is_fraction, "id and frame must be whole numbers")
    order = np.lexsort((cells[:, 1], cells[:, 0]))
    ids, frames = cells[order, 0].astype(np.int64), cells[order, 1].astype(np.int64)
    is_again = np.zeros(len(order), dtype=np.bool_)
    is_again[order[1:]] = (np.diff(ids) == 0) & (np.diff(frames) == 0)
    _refuse(text, is_again, "this person was already seen in this frame")
    return Table("\n".join([*text.comments, text.header or ""]), ids, frames, cells[order, 2:])


def has_rows_of_numbers(path: Path) -> bool:
    """Tell whether a file looks like one without names: rows of 4, 5 or 8 numbers."""
    try:
        text = _sort_lines(path)
    except InvalidInput:
        return False
    return text.header is None and text.width in _COLUMNS


def _sort_lines(path: Path) -> _Text:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InvalidInput(f"{path.name}: is not a text file") from None
    comments = [line.strip("# \t") for line in lines if line.lstrip().startswith("#")]
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.split("#")[0].strip()]
    has_header = bool(rows) and not _is_number(_cells(rows[0][1], _separator(rows[0][1]))[0])
    header = rows.pop(0)[1] if has_header else None
    if not rows:
        raise InvalidInput(f"{path.name}: is empty, there is not one row of numbers in it")
    numbers, kept = [number for number, _ in rows], [line for _, line in rows]
    separator = _separator(kept[0])
    width = len(_cells(kept[0], separator))
    return _Text(path.name, comments, header, kept, numbers, separator, width)


def _separator(line: str) -> str | None:
    return next((mark for mark in ",;" if mark in line), None)


def _cells(line: str, separator: str | None) -> list[str]:
    return [cell.strip() for cell in line.split("#")[0].strip().split(separator)]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _columns(text: _Text) -> list[int]:
    """Return where id, frame, x and y are."""
    ours = {theirs: name for name, synonyms in _NAMES.items() for theirs in synonyms}
    lines = [text.header] if text.header else text.comments
    for line in lines:
        words = _cells(_UNIT.sub("", line), _separator(line))
        names = [ours.get(word.lower(), "") for word in words]
        if len(names) == text.width and set(_NAMES) <= set(names):
            return [names.index(name) for name in _NAMES]
    if text.header:
        raise InvalidInput(
            f"{text.name}: unknown format: {text.width} columns named {text.header.strip()!r}, "
            "needed are frame, id, x and y"
        )
    if text.width not in _COLUMNS:
        raise InvalidInput(
            f"{text.name}: unknown format: {text.width} columns without names; known are "
            "id frame x y, id frame x y z, and frame id x z y vx vz vy"
        )
    return _COLUMNS[text.width]


def _parse(text: _Text) -> Floats:
    """Return all cells as numbers, or say in which line the first fault is."""
    try:
        return np.loadtxt(text.rows, delimiter=text.separator, ndmin=2, dtype=np.float64)
    except ValueError:
        pass
    for number, row in zip(text.numbers, text.rows, strict=True):
        cells = _cells(row, text.separator)
        bad = next((cell for cell in cells if not _is_number(cell)), None)
        if bad is not None:
            raise InvalidInput(f"{text.name}: line {number}: {bad!r} is not a number")
        if len(cells) != text.width:
            raise InvalidInput(
                f"{text.name}: line {number}: {len(cells)} columns instead of {text.width}"
            )
    raise AssertionError("numpy refused a table in which there is no fault")


def _refuse(text: _Text, is_bad: npt.NDArray[np.bool_], fault: str) -> None:
    if is_bad.any():
        raise InvalidInput(f"{text.name}: line {text.numbers[int(np.argmax(is_bad))]}: {fault}")
