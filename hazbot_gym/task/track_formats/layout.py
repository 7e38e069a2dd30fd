"""The layout of a delimited text file: comments, line of names, separator, decimal mark."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.table import MOST_BYTES, UnknownFormat

FEWEST_CELLS = 4
_MOST_CELLS, _LONGEST_LINE = 1000, 1 << 16
_LONGEST_NUMBER = 400  # characters: those of 1e308 without an exponent, and some
_SAMPLE_ROWS = 1000
_BLANKS = re.compile(rb"^[ \t]+(?=#|$)", re.MULTILINE)  # before comments, and in empty lines
_BEFORE_COMMENT = re.compile(r'(?:[^"#]|"[^"]*")*')
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$|[-+]?(nan|inf(inity)?)$", re.I)
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?$")
_TWO_NUMBERS = re.compile(r"[-+.,\deE]+\s+[-+.,\deE]+$")


class Layout(NamedTuple):
    """Parsed layout of a text file.

    Attributes:
        name: of the file.
        data: All bytes, with line feeds between lines.
        encoding: utf-8 or latin-1.
        comments: All lines that start with ``#``, without it.
        header: Line of names, if there is one.
        offset: Byte at which the rows start.
        first_line: Number of the line at that byte, from 1.
        separator: None for blanks.
        decimal: Mark of decimals.
        row: Cells of the first row.
    """

    name: str
    data: bytes
    encoding: str
    comments: list[str]
    header: str | None
    offset: int
    first_line: int
    separator: str | None
    decimal: str
    row: list[str]

    def lines(self) -> Iterator[tuple[int, str]]:
        """Return number and text of each row, without comments and empty lines."""
        for number, line in enumerate(self._text(), self.first_line):
            text = bare(line)
            if text:
                yield number, text

    def _text(self) -> Iterator[str]:
        stream = io.BytesIO(self.data)
        stream.seek(self.offset)
        for line in stream:
            yield line.decode(self.encoding)


def layout_of(path: Path, at_most: int | None = None) -> Layout:
    """Return the layout of a text file.

    Args:
        path: of the file.
        at_most: Bytes that are read; all if not given.

    Raises:
        InvalidInput: the file cannot be read, is not text, or has no row.
    """
    data, encoding = _read(path, at_most)
    comments = [
        line.decode(encoding).strip("# \t\r")
        for line in (re.findall(rb"^#[^\n]*", data, re.MULTILINE) if b"#" in data else [])
    ]
    layout = Layout(path.name, data, encoding, comments, None, 0, 1, None, ".", [])
    number, offset, head = _first(layout)
    if not _is_number(_cells_of(head)[0]):
        layout = layout._replace(header=head, offset=offset, first_line=number + 1)
    rows = [text for (_, text), _ in zip(layout.lines(), range(_SAMPLE_ROWS), strict=False)]
    if not rows:
        raise InvalidInput(f"{path.name}: is empty, there is not one row of numbers in it")
    separator = separator_of(rows[0])
    sample = [cell for row in rows for cell in cells_of(row, separator)]
    has_point = any("." in cell and is_number(cell) for cell in sample)
    has_comma = not has_point and any(_DECIMAL_COMMA.match(cell) for cell in sample)
    row = cells_of(rows[0], separator)
    if len(row) > _MOST_CELLS:
        raise UnknownFormat(path.name, f"{len(row)} columns")
    return layout._replace(separator=separator, decimal="," if has_comma else ".", row=row)


def is_number(cell: str, decimal: str = ".") -> bool:
    """Return True if a cell is a number, NaN and infinity included."""
    if len(cell) > _LONGEST_NUMBER or (decimal == "," and "." in cell):
        return False
    return bool(_NUMBER.match(cell.strip().replace(decimal, ".")))


def bare(line: str) -> str:
    """Return a line without its comment, which a ``#`` outside of quotes starts."""
    found = _BEFORE_COMMENT.match(line)
    end = found.end() if found else 0
    return (line[:end] if line[end : end + 1] == "#" else line).strip()


def separator_of(line: str) -> str | None:
    """Return the separator of a row's cells; None for blanks."""
    marks = [mark for mark in ";\t," if mark in line]
    for mark in marks:
        cells = cells_of(line, mark)
        if len(cells) >= FEWEST_CELLS and not any(_TWO_NUMBERS.match(cell) for cell in cells):
            return mark
    if not marks or len(cells_of(line, None)) >= FEWEST_CELLS:
        return None
    return marks[0]


def cells_of(line: str, separator: str | None) -> list[str]:
    """Return the cells of a row, without quotes and blanks around them."""
    if separator is None:
        line, separator = re.sub(r"\s+", " ", line.strip()), " "
    try:
        rows = list(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except csv.Error as error:
        raise InvalidInput(f"unknown format: {error} in {line[:40]!r}") from None
    return [cell.strip() for cell in rows[0]] if rows else []


def _cells_of(line: str) -> list[str]:
    return cells_of(line, separator_of(line))


def _is_number(cell: str) -> bool:
    return is_number(cell) or bool(_DECIMAL_COMMA.match(cell))


def _first(layout: Layout) -> tuple[int, int, str]:
    """Return number, end and text of the first line that is neither empty nor a comment."""
    start = 0
    for number in itertools.count(1):
        if start == len(layout.data):
            break
        end = layout.data.find(b"\n", start)
        end = len(layout.data) if end < 0 else end + 1
        if end - start > _LONGEST_LINE:
            raise UnknownFormat(layout.name, f"line {number} has {end - start} bytes")
        text = bare(layout.data[start:end].decode(layout.encoding))
        if text:
            return number, end, text
        start = end
    raise InvalidInput(f"{layout.name}: is empty, there is not one row of numbers in it")


def _read(path: Path, at_most: int | None) -> tuple[bytes, str]:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InvalidInput(f"{path.name}: is larger than 256 MiB")
        with path.open("rb") as file:
            data = file.read() if at_most is None else file.read(at_most)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be read ({error.strerror})") from None
    if b"\0" in data:
        raise InvalidInput(f"{path.name}: is not a text file")
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if data[:1] in b" \t" or b"\n " in data or b"\n\t" in data:
        data = _BLANKS.sub(b"", data)
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data, "latin-1"
    return data, "utf-8"
