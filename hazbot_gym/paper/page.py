"""HTML page of the reproduction: sections with numbers, tables and figures."""

from __future__ import annotations

import base64
from importlib import resources

from hazbot_gym import __version__
from hazbot_gym.errors import MissingExtra
from hazbot_gym.paper.chapter import Cell, Chapter, Table
from hazbot_gym.paper.lines import lines
from hazbot_gym.paper.numbers import REPRODUCED, reported
from hazbot_gym.paper.tables import (
    BASIS_TITLES,
    basis_rows,
    prediction_line,
    shown,
    shown_basis,
    shown_paper,
    shown_tolerance,
    summary_line,
)
from hazbot_gym.utils import text_tables
from hazbot_gym.utils.json_object import JsonObject

try:
    import jinja2
except ImportError as error:
    raise MissingExtra(error.name or "jinja2", "study") from error


LONG = 12  # characters beyond a number with its unit


def make_page(record: JsonObject, chapters: list[Chapter]) -> str:
    """Return the page as HTML; the same text for the same results."""
    numbers = {entry["id"]: entry for entry in record["numbers"]}
    own = {chapter.number: [numbers[name] for name in chapter.here] for chapter in chapters}
    found = {name for chapter in chapters for name in chapter.here}
    return (
        _environment()
        .get_template("page.html")
        .render(
            record=record,
            version=__version__,
            summary=summary_line(record),
            bases=(BASIS_TITLES, basis_rows(record)),
            predictions=prediction_line(record),
            chapters=chapters,
            numbers=own,
            missed=[entry for entry in record["numbers"] if entry["verdict"] != REPRODUCED],
            absent=[entry for name, entry in numbers.items() if name not in found],
            rules=reported().rules,
            lines=lines(),
        )
    )


def _cell(value: Cell) -> str:
    return value if isinstance(value, str) else text_tables.shown(value)


def _wordy(table: Table) -> set[int]:
    """Return the text columns, which are left-aligned."""
    return {
        place
        for row in table.rows
        for place, value in enumerate(row)
        if isinstance(value, str) and " " in value and len(value) > LONG
    }


def _data(svg: str) -> str:
    """Return a picture as a data URI."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def _environment() -> jinja2.Environment:
    """Return the template environment, with autoescape."""
    root = resources.files("hazbot_gym")
    folders = (root / "paper", root / "study" / "report" / "template")

    def load(name: str) -> str:
        folder = next(folder for folder in folders if (folder / name).is_file())
        return (folder / name).read_text(encoding="utf-8")

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(load),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {
        "basis": shown_basis,
        "cell": _cell,
        "data": _data,
        "paper": shown_paper,
        "shown": shown,
        "tolerance": shown_tolerance,
        "wordy": _wordy,
    }
    return environment
