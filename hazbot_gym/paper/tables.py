"""The table "paper | here | verdict", on the terminal."""

from __future__ import annotations

from rich.text import Text

from hazbot_gym.paper.numbers import NEAR, NOT, REPRODUCED
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.terminal import FittedTable

COLORS = {REPRODUCED: "green", NEAR: "yellow"}


def shown(value: float | None, unit: str = "") -> str:
    """Format a number in the paper's precision, with its unit; a dash for None."""
    if value is None:
        return "-"
    return f"{round(value, 4):g} {unit}".rstrip()


def verdict_table(record: JsonObject) -> FittedTable:
    """Return one row for each number that the paper reports."""
    table = FittedTable(box=None, pad_edge=False, spare=("tolerance", "where"))
    table.add_column("where", style="dim")
    table.add_column("what")
    for title in ("paper", "here", "tolerance"):
        table.add_column(title, justify="right", no_wrap=True)
    table.add_column("verdict")
    last = ""
    for entry in record["numbers"]:
        word = entry["verdict"].partition(":")[0]
        table.add_row(
            entry["source"] if entry["source"] != last else "",
            entry["what"],
            shown(entry["paper"], entry["unit"]),
            shown(entry["here"]),
            f"± {shown(entry['tolerance'])}" if entry["tolerance"] else "equal",
            Text(entry["verdict"], style=COLORS.get(word, "red")),
        )
        last = entry["source"]
    return table


def summary_line(record: JsonObject) -> str:
    """Return a line with the count of each verdict."""
    counts = ", ".join(f"{record['verdicts'][word]} {word}" for word in (REPRODUCED, NEAR, NOT))
    return f"{record['reported']} numbers reported: {counts}."
