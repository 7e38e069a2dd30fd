"""What a section of the paper comes to here: values, tables, pictures and text, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

Cell = str | float | None


class Table(NamedTuple):
    """A table of the page; numbers are shown with three digits that count."""

    caption: str
    head: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]


class Picture(NamedTuple):
    """A figure of the page."""

    name: str  # of its file, without ending: lower case, words joined by hyphens
    paper: str  # the paper's figure that it stands for, such as "Figure 3"; "" if there is none
    caption: str  # what is seen, for somebody who has only the paper in hand
    svg: str


class Chapter(NamedTuple):
    """A section of the paper, run again.

    Attributes:
        number: Of the section, such as "3.1".
        title: Of the section.
        here: What came out for the paper's reported numbers, by their id in ``numbers.yaml``.
        record: What else was measured, as values for JSON.
        text: Paragraphs; figures in them are filled in from what was measured.
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
