"""The docs page "The paper, line by line", from a committed ``paper.json``."""

from __future__ import annotations

from collections.abc import Mapping
from string import Template
from typing import Any

from hazbot_gym.paper.tables import shown, summary_line
from hazbot_gym.study.plain_tables import Rows, markdown_table

Record = Mapping[str, Any]


def page(template: str, record: Record, *, name: str) -> str:
    """Fill the page's template.

    Args:
        template: With ``$`` placeholders.
        record: A ``paper.json``.
        name: Of its file, from the root of the repository.
    """
    return Template(template).substitute(
        record=name,
        summary=summary_line(record),
        lines=markdown_table(("item", "what", "here", "in the code"), line_rows(record)),
        numbers=markdown_table(
            ("number", "where", "paper", "here", "tolerance", "verdict"), number_rows(record)
        ),
        missed=markdown_table(("number", "paper", "here", "verdict"), missed_rows(record)),
    )


def line_rows(record: Record) -> Rows:
    """Return a row for each equation, table and figure."""
    return [
        (
            line["item"],
            line["what"],
            f"**{line['status']}**" + (f": {line['note']}" if line["note"] else ""),
            " ".join(f"`{place}`" for place in line["code"]),
        )
        for line in record["lines"]
    ]


def number_rows(record: Record) -> Rows:
    """Return a row for each number that the paper reports."""
    return [
        (
            entry["what"],
            entry["source"],
            shown(entry["paper"], entry["unit"]),
            shown(entry["here"]),
            shown(entry["tolerance"]) if entry["tolerance"] else "equal",
            entry["verdict"].partition(":")[0],
        )
        for entry in record["numbers"]
    ]


def missed_rows(record: Record) -> Rows:
    """Return a row for each number that is not reproduced, with the reason."""
    return [
        (
            f"{entry['what']} ({entry['source']})",
            shown(entry["paper"], entry["unit"]),
            shown(entry["here"]),
            entry["verdict"],
        )
        for entry in record["numbers"]
        if entry["verdict"] != "reproduced"
    ]
