"""Headroom results, as a table on the terminal."""

from __future__ import annotations

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

TITLES = ("environment", "best constant", "optimum", "family", "return", "arrived", "in the span")
SPARE = ("best constant", "optimum", "arrived", "return")  # of a narrow terminal


def table(record: Record) -> FittedTable:
    """Return a record as a table for the terminal."""
    return console_table(TITLES, family_rows(record), spare=SPARE)


def percent(share: float) -> str:
    """Return a share in percent, without decimals."""
    return f"{100.0 * share:.0f} %"


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
