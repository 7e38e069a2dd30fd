"""Consoles for results and progress, and tables that fit their width.

Text is printed literally: brackets and colons in a name are never read as rich's markup. A
character that the output's encoding lacks is replaced by its nearest ASCII letter, or by ``?``; one
that controls the terminal, or turns the direction of writing, always by ``?``.
"""

from __future__ import annotations

import codecs
import copy
import dataclasses
import io
import sys
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, TextIO

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Column, Table
from rich.text import Text

from hazbot_gym.errors import DoubtfulPlace, DoubtfulRecording

PIPED_WIDTH = 120  # columns of output that goes into a file or another program
_LEAST_FOLDED = 12  # columns that a text which may break anywhere is left with


def output_console(file: TextIO | None = None, *, width: int | None = None) -> Console:
    """Return the console of results, on stdout if no file is given.

    Args:
        file: Output stream.
        width: Columns; None for the terminal's, or for ``PIPED_WIDTH`` where there is no terminal.
    """
    stream = file or sys.stdout
    if width is None and not stream.isatty():
        width = PIPED_WIDTH
    return _console(stream, width)


def progress_console() -> Console:
    """Return the console of progress and remarks, on stderr."""
    return _console(sys.stderr, None)


def progress_bar(console: Console, *columns: ProgressColumn) -> Progress:
    """Return a progress bar, silent if the console is no terminal."""
    usual = (plain_column("{task.description}"), BarColumn(), MofNCompleteColumn())
    is_silent = not (console.is_terminal and console.file.isatty())
    return Progress(*(columns or usual), TimeRemainingColumn(), console=console, disable=is_silent)


def plain_column(template: str) -> TextColumn:
    """Return a progress bar column with literal text."""
    return TextColumn(template, markup=False)


def printable(text: str) -> str:
    """Return a text without control characters except line breaks and tabs."""
    return "".join(each if each.isprintable() or each in "\n\t" else "?" for each in text)


def one_line(text: str) -> str:
    """Return a text as a single line without control characters."""
    return printable(" ".join(text.split()))


def warn_in_one_line() -> None:
    """Print warnings about user files as one line on stderr, once; others as usual."""
    usual, said = warnings.showwarning, set[str]()

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, DoubtfulPlace | DoubtfulRecording):
            usual(message, category, *where, **more)
        elif str(message) not in said:
            said.add(str(message))
            print(f"hazbot: warning: {one_line(str(message))}", file=sys.stderr)

    warnings.showwarning = show


def tolerate(stream: TextIO) -> None:
    """Set a stream to replace unencodable characters, unless configured otherwise."""
    if isinstance(stream, io.TextIOWrapper) and stream.errors in ("strict", "surrogateescape"):
        stream.reconfigure(errors=_REPLACE)


class FittedTable(Table):
    """Table that omits columns on narrow consoles.

    Numbers are never broken or clipped; a line below names the omitted columns.

    Args:
        spare: Titles of columns that may be omitted, in order; None for all but the first column,
            from the last one.
    """

    def __init__(
        self, *titles: Column | str, spare: Sequence[str] | None = None, **options: Any
    ) -> None:
        super().__init__(*titles, **options)
        self.spare = spare

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield the table and, if columns were omitted, a line that names them."""
        spans = {id(column): _span(console, options, column) for column in self.columns}
        kept, left_out = list(self.columns), []
        for column in self._spare_columns():
            if self._room(options, kept) >= sum(spans[id(each)].minimum for each in kept):
                break
            kept.remove(column)
            left_out.append(_title(column))
        shown = copy.copy(self)
        # rich pads the first and the last column by the number that each has.
        shown.columns = [dataclasses.replace(each, _index=k) for k, each in enumerate(kept)]
        room, needs = self._room(options, kept), [spans[id(column)] for column in kept]
        if room >= sum(need.minimum for need in needs):
            for column, width in zip(shown.columns, _widths(room, needs), strict=True):
                column.width = width
        else:  # nothing more may be left out: words break, but nothing is lost
            for column in shown.columns:
                column.overflow, column.no_wrap = "fold", False
        yield from Table.__rich_console__(shown, console, options)
        if left_out:
            yield Text(printable(f"Too narrow to show: {', '.join(left_out)}."), style="dim")

    def _spare_columns(self) -> Iterable[Column]:
        if self.spare is None:
            return reversed(self.columns[1:])
        by_title = {column.header: column for column in self.columns}
        return [by_title[title] for title in self.spare]

    def _room(self, options: ConsoleOptions, columns: list[Column]) -> int:
        """Return the width of the cells without padding and borders."""
        _, right, _, left = self.padding
        borders = len(columns) + 1 if self.box else 0
        return options.max_width - borders - (left + right) * len(columns)


def _title(column: Column) -> str:
    return " ".join(str(column.header).split())


def _span(console: Console, options: ConsoleOptions, column: Column) -> Measurement:
    """Return the minimum width without broken words, and the maximum useful width."""
    wide = options.update(width=10_000)
    found = [Measurement.get(console, wide, cell) for cell in (column.header, *column.cells)]
    widest = max(max(each.maximum for each in found), column.min_width or 0)
    if column.no_wrap:
        least = widest
    elif column.overflow == "fold":
        least = min(widest, column.min_width or _LEAST_FOLDED)
    else:
        least = max(max(each.minimum for each in found), column.min_width or 0)
    return Measurement(least, widest)


def _widths(room: int, needs: Sequence[Measurement]) -> list[int]:
    """Distribute the width: the minimum to each column, the rest to wider ones."""
    widths, left = [need.minimum for need in needs], room - sum(need.minimum for need in needs)
    wanting = sorted(range(len(needs)), key=lambda k: needs[k].maximum - needs[k].minimum)
    for rank, k in enumerate(wanting):
        given = min(needs[k].maximum - needs[k].minimum, left // (len(needs) - rank))
        widths[k] += given
        left -= given
    return widths


class _SafeConsole(Console):
    """A console that removes control characters."""

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(printable(text), **options)


def _console(stream: TextIO, width: int | None) -> Console:
    tolerate(stream)
    console = _SafeConsole(file=stream, width=width, markup=False, emoji=False)
    if not console.width:  # COLUMNS=0
        console.width = PIPED_WIDTH
    return console


def _nearest(error: UnicodeError) -> tuple[str, int]:
    """Return replacements of unencodable characters, of equal length."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lost = error.object[error.start : error.end]
    return "".join(_plain_letters(lost)), error.end


def _plain_letters(text: str) -> Iterator[str]:
    for letter in text:
        plain = unicodedata.normalize("NFKD", letter)[0]
        yield plain if plain.isascii() else "?"


_REPLACE = f"{__name__}.nearest"
codecs.register_error(_REPLACE, _nearest)
