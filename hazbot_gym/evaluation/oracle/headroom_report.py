"""Headroom results, as a table on the terminal and as a page of the documentation."""

from __future__ import annotations

from string import Template

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.utils.text_tables import Rows, console_table, markdown_table, shown

Record = JsonObject

TITLES = ("environment", "best constant", "optimum", "family", "return", "arrived", "in the span")
SPARE = ("best constant", "optimum", "arrived", "return")  # of a narrow terminal
ROOM = ("environment", "room", "left by")


def table(record: Record) -> FittedTable:
    """Return a record as a table for the terminal."""
    return console_table(TITLES, family_rows(record), spare=SPARE)


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page on headroom: a template with its placeholders filled in."""
    wide = [env for env, found in record["environments"].items() if has_room(found, record)]
    narrow = [env for env in record["environments"] if env not in wide]
    return Template(template).substitute(
        record=name,
        episodes=record["episodes"],
        enough=percent(record["enough"]),
        wide=_names(wide),
        narrow=_names(narrow),
        rooms=markdown_table(ROOM, room_rows(record)),
        families=markdown_table(TITLES, family_rows(record)),
    )


def has_room(found: Record, record: Record) -> bool:
    """Return True if the best rule leaves enough of an environment's span."""
    return bool(found["room"] >= record["enough"])


def percent(share: float) -> str:
    """Return a share in percent, without decimals."""
    return f"{100.0 * share:.0f} %"


def room_rows(record: Record) -> Rows:
    """Return the headroom of every environment, and the best rule."""
    rows: Rows = []
    for env, found in record["environments"].items():
        rules = {name: row for name, row in found["families"].items() if name != "fuzzy_expert"}
        best = max(rules.values(), key=lambda row: row["share"])
        rows.append((f"`{env}`", percent(found["room"]), f"`{best['policy']}`"))
    return rows


def family_rows(record: Record) -> Rows:
    """Return the position of every family's best member within the span."""
    return [
        (
            f"`{env}`",
            shown(found["constant"]),
            shown(found["optimum"]),
            f"`{row['policy']}`",
            shown(row["return"]),
            percent(row["arrived"]),
            percent(row["share"]),
        )
        for env, found in record["environments"].items()
        for row in found["families"].values()
    ]


def _names(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"
