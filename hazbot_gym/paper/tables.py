"""The table "paper | here | verdict", on the terminal."""

from __future__ import annotations

from collections import Counter

from rich.text import Text

from hazbot_gym.paper.numbers import BASES, NEAR, REPRODUCED, VERDICTS
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.terminal import FittedTable
from hazbot_gym.utils.text_tables import Rows

COLORS = {REPRODUCED: "green", NEAR: "yellow"}
BASIS_TITLES = ("basis", "numbers", *VERDICTS)


def shown(value: float | None, unit: str = "") -> str:
    """Format a number in the paper's precision, with its unit; a dash for None."""
    if value is None:
        return "-"
    return f"{round(value, 4):g} {unit}".rstrip()


def shown_paper(entry: JsonObject) -> str:
    """Format the paper's number of an entry, with the relation of a bound."""
    bound = "" if entry["relation"] == "=" else f"{entry['relation']} "
    return bound + shown(entry["paper"], entry["unit"])


def shown_tolerance(entry: JsonObject) -> str:
    """Format the tolerance of an entry."""
    if entry["relation"] != "=":
        return "bound"
    return f"± {shown(entry['tolerance'])}" if entry["tolerance"] else "equal"


def shown_basis(basis: str | None) -> str:
    """Format a basis; a dash for None."""
    return basis.replace("_", " ") if basis else "-"


def verdict_table(record: JsonObject) -> FittedTable:
    """Return one row for each number that the paper reports."""
    table = FittedTable(box=None, pad_edge=False, spare=("tolerance", "where", "basis"))
    table.add_column("where", style="dim")
    table.add_column("what")
    for title in ("paper", "here", "tolerance"):
        table.add_column(title, justify="right", no_wrap=True)
    for title in ("basis", "verdict"):
        table.add_column(title)
    last = ""
    for entry in record["numbers"]:
        word = entry["verdict"].partition(":")[0]
        table.add_row(
            entry["source"] if entry["source"] != last else "",
            entry["what"],
            shown_paper(entry),
            shown(entry["here"]),
            shown_tolerance(entry),
            shown_basis(entry["basis"]),
            Text(entry["verdict"], style=COLORS.get(word, "red")),
        )
        last = entry["source"]
    return table


def summary_line(record: JsonObject) -> str:
    """Return the count of each verdict, and the share of each basis among the reproduced."""
    counts = ", ".join(f"{record['verdicts'][word]} {word}" for word in VERDICTS)
    found = record["verdicts_by_basis"]
    by_basis = ", ".join(
        f"{found[basis][REPRODUCED]} of {sum(found[basis].values())} {shown_basis(basis)}"
        for basis in BASES
    )
    return f"{record['reported']} numbers reported: {counts}. Reproduced by basis: {by_basis}."


def basis_rows(record: JsonObject) -> Rows:
    """Return the verdicts of each basis, under ``BASIS_TITLES``."""
    found = record["verdicts_by_basis"]
    return [
        (
            shown_basis(basis),
            str(sum(found[basis].values())),
            *(str(found[basis][word]) for word in VERDICTS),
        )
        for basis in BASES
    ]


def prediction_line(record: JsonObject) -> str:
    """Return the places in the paper of the reproduced predictions, with their counts."""
    places = Counter(
        entry["source"].partition(", row")[0]
        for entry in record["numbers"]
        if entry["basis"] == "predicted" and entry["verdict"] == REPRODUCED
    )
    found = "; ".join(f"{place}: {count}" for place, count in places.items())
    return f"Predicted and reproduced: {found}."
