"""Column names in track files: roles (id, frame or time, x, y) and units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats.table import Unit

# Our name of a column -> its names in files, in lower case without blanks, dots and underscores.
_SYNONYMS = {
    "id": (
        *("id", "persid", "personid", "pedid", "pedestrianid", "trackid", "agentid", "objectid"),
        *("humanid", "targetid", "person", "pedestrian", "ped", "track"),
    ),
    "frame": ("frame", "fr", "frameid", "framenumber", "frameno", "framenr", "frameindex"),
    "time": ("time", "t", "timestamp", "seconds", "sec", "simtime", "simsec"),
    "x": ("x", "posx", "xpos", "positionx", "xposition", "xcenter", "centerx", "xcentre"),
    "y": ("y", "posy", "ypos", "positiony", "yposition", "ycenter", "centery", "ycentre"),
    "xmin": ("xmin",),
    "xmax": ("xmax",),
    "ymin": ("ymin",),
    "ymax": ("ymax",),
    "lost": ("lost",),
    "label": (
        *("label", "class", "classname", "type", "category", "agenttype", "objecttype"),
        *("agentclass", "objectclass", "classlabel"),
    ),
}
_OURS = {theirs: ours for ours, synonyms in _SYNONYMS.items() for theirs in synonyms}
_LENGTHS: dict[str, Unit] = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), "m"),
    "cm": "cm",
    "mm": "mm",
    **dict.fromkeys(("px", "pixel", "pixels", "pix"), "px"),
}
_SECONDS = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNITS = "|".join(sorted({*_LENGTHS, *_SECONDS}, key=len, reverse=True))
_UNIT = re.compile(rf"(?:\s*[/\[(]\s*({_UNITS})\s*[\])]?|[_ ]({_UNITS}))$", re.IGNORECASE)
UNIT_WORDS = "|".join(sorted(_LENGTHS, key=len, reverse=True))
BOX = ("xmin", "xmax", "ymin", "ymax")


class Column(NamedTuple):
    """A column from its name: our name or "", and the unit or ""."""

    ours: str
    unit: str


class Roles(NamedTuple):
    """Roles of columns.

    Attributes:
        at: Index of the column by our name.
        unit: Unit of the positions, if the names say so.
        second_s: Unit of the time stamps in seconds.
        names: Our names of all columns, "-" for those not read.
    """

    at: dict[str, int]
    unit: Unit | None
    second_s: float
    names: str

    @property
    def is_box(self) -> bool:
        """True if positions are centers of boxes."""
        return "x" not in self.at


def column(name: str) -> Column:
    """Parse the name of a column: ``x/cm``, ``pos_x [m]``, ``timestamp_ms``."""
    name = " ".join(name.strip("\"' \t").split())
    ours = _OURS.get(_bare(name), "")
    found = _UNIT.search(name)
    if ours or not found:
        return Column(ours, "")
    unit = (found[1] or found[2]).lower()
    return Column(_OURS.get(_bare(name[: found.start()]), ""), unit)


def length_unit(word: str) -> Unit | None:
    """Return the unit of a word such as ``cm`` or ``meters``."""
    return _LENGTHS.get(word.lower())


def roles_of(names: Sequence[str]) -> Roles | None:
    """Return the roles of columns; None if id, frame or time, x or y is missing.

    Raises:
        InvalidInput: two columns could hold the same, or x and y differ in their units.
    """
    columns = [column(name) for name in names]
    ours = [each.ours for each in columns]
    has_box = all(edge in ours for edge in BOX) and not {"x", "y"} <= set(ours)
    position = BOX if has_box else ("x", "y")
    clock = "frame" if "frame" in ours else "time"
    needed = ("id", clock, *position)
    if not set(needed) <= set(ours):
        return None
    for role in needed:
        same = [name.strip() for name, each in zip(names, ours, strict=True) if each == role]
        if len(same) > 1:
            raise InvalidInput(
                f"two columns could be {role}: {same[0]!r} and {same[1]!r}; "
                "say which with columns, and - for the other"
            )
    wanted = {*needed, "time", "label", *(("lost",) if has_box else ())}
    at = {role: ours.index(role) for role in ours if role in wanted}
    units = {columns[at[role]].unit for role in position}
    if len(units) > 1 or any(unit and unit not in _LENGTHS for unit in units):
        raise InvalidInput(f"x and y have no unit of length in common: {', '.join(sorted(units))}")
    stamp = columns[at["time"]].unit if "time" in at else ""
    return Roles(
        at,
        _LENGTHS.get(units.pop()),
        _SECONDS.get(stamp, 1.0),
        " ".join(role if at.get(role) == i else "-" for i, role in enumerate(ours)),
    )


def _bare(name: str) -> str:
    return re.sub(r"[\s_.\-]", "", name).lower()
