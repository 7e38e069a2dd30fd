"""Tables as text: comma, semicolon, tabulator or blank separated, with names of columns or without.

Names are given, or are on the first line or in a comment. Otherwise the order is inferred
(``orders``). Stanford Drone annotations are ten columns, boxes in pixels with a label.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats import clock, orders
from hazbot_gym.task.track_formats.cells import Cells
from hazbot_gym.task.track_formats.layout import (
    Layout,
    cells_of,
    is_number,
    layout_of,
)
from hazbot_gym.task.track_formats.names import UNIT_WORDS, Roles, length_unit, roles_of
from hazbot_gym.task.track_formats.table import (
    LARGEST_WHOLE,
    Given,
    Table,
    Unit,
    UnknownFormat,
    check_numbers,
    sorted_sightings,
)

DRONE = "id xmin ymin xmax ymax frame lost occluded generated label"
_PEOPLE = {"pedestrian", "pedestrians", "person", "people", "human", "walker"}  # of labels
_VEHICLES = {
    *("bicycle", "bicyclist", "bike", "biker", "bus", "car", "cart", "cyclist", "motorbike"),
    *("motorcycle", "motorcyclist", "rider", "skater", "tram", "truck", "truck_bus", "van"),
    *("vehicle", "trailer", "scooter", "bikes", "cars", "heavy vehicle", "bicycles"),
}
_NUMBER = r"([-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[-+]?\d+)?)(?![\w.,])"
_RATES = (
    re.compile(
        rf"(?:frame[ _-]?rate|\bfps)\b\s*(?:[\[(][^\])]*[\])])?\s*(?:[:=]|is\b|of\b)?\s*{_NUMBER}",
        re.IGNORECASE,
    ),
    re.compile(rf"(?<![\w.,]){_NUMBER}\s*(?:fps\b|frames (?:per|a) second)", re.IGNORECASE),
)
_UNITS = (
    re.compile(rf"\bx\s*(?:/|\[|\(|in\b)\s*({UNIT_WORDS})\b", re.IGNORECASE),
    re.compile(rf"\bunits?\s*[:=]?\s*\(?({UNIT_WORDS})\b", re.IGNORECASE),
)


class _Named(NamedTuple):
    """The columns of a table by role, and the source of their names."""

    roles: Roles
    form: str
    form_from: str


def read(path: Path, given: Given) -> Table:
    """Read a table.

    Raises:
        UnknownFormat: the columns are ambiguous.
        InvalidInput: the file cannot be read, or a cell is not what it must be.
    """
    layout = layout_of(path)
    try:
        named = _named(layout, given)
    except UnknownFormat:
        raise
    except InvalidInput as fault:
        raise InvalidInput(f"{path.name}: {fault}") from None
    named = named or _nameless(layout)
    roles = named.roles
    cells = Cells(layout, roles.at.values())
    notes = _leave_out(cells, roles, path.name)
    ids, positions = cells.ids(roles.at["id"]), _positions(cells, roles)
    frames, fps, fps_from = _frames(layout, cells, roles, ids, given)
    unit, unit_from = _unit(layout, named)
    return Table(
        *sorted_sightings(path.name, ids, frames, positions, cells.place_of),
        form=named.form,
        form_from=named.form_from,
        fps=fps,
        fps_from=fps_from,
        unit=unit,
        unit_from=unit_from,
        notes=notes,
    )


# --- which column is which -----------------------------------------------------------------------


def _named(layout: Layout, given: Given) -> _Named | None:
    """Return the columns from given names or names in the file; None without names."""
    width = len(layout.row)
    if given.columns is not None:
        roles = roles_of(given.columns)
        if roles is None:
            raise InvalidInput(
                f"columns: given {' '.join(given.columns)!r}, needed are id, frame or time, x and y"
            )
        if len(given.columns) != width:
            raise InvalidInput(f"columns: given {len(given.columns)} names for {width} columns")
        return _Named(roles, roles.names, given.columns_from)
    lines = [layout.header] if layout.header else layout.comments
    for line in lines:
        names = _names(line)
        if len(names) < width and layout.header and not any(layout.row[len(names) :]):
            names += ["-"] * (width - len(names))  # rows may end with separators
        roles = roles_of(names) if layout.header or len(names) == width else None
        if roles and len(names) != width:
            number, _ = next(layout.lines())
            raise InvalidInput(f"line {number}: {width} columns instead of {len(names)}")
        if roles:
            return _Named(roles, roles.names, "names in the file")
    if layout.header:
        what = f"{width} columns named {layout.header.strip()[:200]!r}"
        raise UnknownFormat(layout.name, what)
    return None


def _names(line: str) -> list[str]:
    """Return the names in a line; blanks before a unit, as in ``x [m]``, separate nothing."""
    mark = next((mark for mark in ";\t," if mark in line), None)
    if mark is None:
        line = " ".join(line.split())
        line = re.sub(r"\s*([/\[(])\s*(\w+)(\s*[\])])?", r"\1\2\3", line)
    return cells_of(line, mark)


def _nameless(layout: Layout) -> _Named:
    """Return the columns of a table without names."""
    width = len(layout.row)
    is_text = [not is_number(cell, layout.decimal) for cell in layout.row]
    if width == len(DRONE.split()) and is_text[-1] and not any(is_text[:-1]):
        return _told(DRONE, "Stanford Drone annotations", "format")
    if width not in orders.REST:
        raise UnknownFormat(layout.name, f"{width} columns without names")
    cells = Cells(layout, range(width))
    table = np.column_stack([cells.numbers(column) for column in range(width)])
    with np.errstate(invalid="ignore"):
        is_fraction = (table[:, :2] % 1.0 != 0.0).any(axis=1) & np.isfinite(table).all(axis=1)
    if is_fraction.any():
        place = cells.place_of(int(np.argmax(is_fraction)))
        raise InvalidInput(
            f"{layout.name}: {place}: without names the first two columns are id and frame, whole "
            "numbers; give columns, such as 'time id x y'"
        )
    check_numbers(layout.name, table[:, 0], table[:, 1], table[:, 2:], cells.place_of)
    order = orders.recognized(layout.name, table)
    return _told(order, order, "recognized from the values")


def _told(order: str, form: str, form_from: str) -> _Named:
    roles = roles_of(order.split())
    assert roles is not None
    return _Named(roles, form, form_from)


# --- what the columns hold -----------------------------------------------------------------------


def _leave_out(cells: Cells, roles: Roles, name: str) -> tuple[str, ...]:
    """Drop boxes marked as lost, and rows with labels other than people.

    Boxes are of pedestrians or of something else; a label beside a point may say anything, such as
    ``adult``, and only names of vehicles count.
    """
    notes = []
    if "lost" in roles.at:
        is_lost = cells.numbers(roles.at["lost"]) != 0.0
        cells.keep(~is_lost)
        notes += [f"{is_lost.sum()} lost positions are left out"] if is_lost.any() else []
    if "label" in roles.at:
        labels = [label.strip("\"' ").lower() for label in cells.texts(roles.at["label"])]
        others = {label for label in set(labels) if label not in _PEOPLE}
        left_out = others if roles.is_box else others & _VEHICLES
        cells.keep(np.array([label not in left_out for label in labels], dtype=np.bool_))
        named = ", ".join(sorted(left_out))
        notes += [f"only pedestrians are read, not: {named}"] if left_out else []
    if not len(cells.rows):
        raise InvalidInput(f"{name}: there is no pedestrian in it")
    return tuple(notes)


def _positions(cells: Cells, roles: Roles) -> Floats:
    if not roles.is_box:
        return np.column_stack([cells.numbers(roles.at[axis]) for axis in "xy"])
    edges = [[cells.numbers(roles.at[f"{axis}{end}"]) for end in ("min", "max")] for axis in "xy"]
    return np.column_stack([(low + high) / 2.0 for low, high in edges])


def _frames(
    layout: Layout, cells: Cells, roles: Roles, ids: Floats, given: Given
) -> tuple[Floats, float | None, str]:
    """Return the frame of each row, and the frames per second with their source."""
    commented = _rate(layout)
    if "frame" in roles.at:
        frames = cells.numbers(roles.at["frame"])
        is_usable = np.abs(frames).max() <= LARGEST_WHOLE  # others are rejected later
        if commented or given.fps or "time" not in roles.at or not is_usable:
            return frames, commented, "comment" if commented else ""
        times_s = cells.times_s(roles.at["time"], roles.second_s)
        return frames, clock.rate_of(frames, times_s), "time column"
    times_s = cells.times_s(roles.at["time"], roles.second_s)
    whole, fps = clock.frames_of(layout.name, ids, times_s, given.fps or commented)
    return whole.astype(np.float64), fps, "time column"


def _rate(layout: Layout) -> float | None:
    """Return the frame rate in comments.

    Raises:
        InvalidInput: they contain two rates.
    """
    lines = [" ".join(line.split()) for line in (*layout.comments, layout.header or "")]
    found = {
        float(match[1].replace(",", "."))
        for pattern in _RATES
        for line in lines
        for match in pattern.finditer(line)
    }
    if len(found) > 1:
        rates = " and ".join(f"{rate:g}" for rate in sorted(found))
        raise InvalidInput(f"{layout.name}: comments tell different frame rates: {rates}; give fps")
    return found.pop() if found else None


def _unit(layout: Layout, named: _Named) -> tuple[Unit | None, str]:
    """Return the unit of positions in names or comments, and its source."""
    if named.roles.unit:
        return named.roles.unit, named.form_from
    if named.roles.is_box:
        return "px", "format"
    for pattern in _UNITS:
        for line in layout.comments:
            found = pattern.search(" ".join(line.split()))
            if found:
                return length_unit(found[1]), "comment"
    return None, ""
