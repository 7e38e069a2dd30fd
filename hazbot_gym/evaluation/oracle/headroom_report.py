"""Headroom results, as a table on the terminal."""

from __future__ import annotations

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

SHARE = "normalized return"  # 0 % at the best constant speed, 100 % at the optimum
TITLES = ("environment", "best constant", "optimum", "family", "return", "arrived", SHARE)
SPARE = ("best constant", "optimum", "arrived", "return")  # of a narrow terminal


def table(record: Record) -> FittedTable:
    """Return a record as a table for the terminal."""
    rows = [tuple(cell.strip("`") for cell in row) for row in family_rows(record)]
    return console_table(TITLES, rows, spare=SPARE)


def percent(share: float) -> str:
    """Return a share in percent, without decimals."""
    return f"{100.0 * share:.0f} %"


def family_rows(record: Record) -> Rows:
    """Return the best member of every family, in Markdown, with its normalized return."""
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
