"""Results of a section of the paper: values, tables, figures and text, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

Cell = str | float | None


class Table(NamedTuple):
    """A table of the page; numbers are shown with three significant digits."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]


class Picture(NamedTuple):
    """A figure of the page."""

    name: str  # of its file, without ending: lower case, words joined by hyphens
    paper: str  # the paper's figure that it reproduces, such as "Figure 3", or ""
    caption: str  # caption, for a reader of the paper
    svg: str


class Chapter(NamedTuple):
    """Reproduction of a section of the paper.

    Attributes:
        number: Of the section, such as "3.1".
        title: Of the section.
        here: Reproduced values of the paper's reported numbers, by their id in ``numbers.yaml``.
        record: Further measured values, for JSON.
        text: Paragraphs; numbers in them come from measurements.
        tables: Tables of the page.
        pictures: Figures of the page.
    """

    number: str
    title: str
    here: dict[str, float]
    record: dict[str, object]
    text: tuple[str, ...]
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
