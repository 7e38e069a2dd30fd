"""The docs page "The paper, line by line", from a committed ``paper.json``."""

from __future__ import annotations

from string import Template
from typing import Any

from table_text import csv_table, markdown_table

from hazbot_gym.calibration.report import DIFFERENCES, difference_rows
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
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows

Record = JsonObject
LINES = ("item", "what", "here", "in the code")
NUMBERS = ("number", "where", "paper", "here", "tolerance", "basis", "verdict")
MISSED = ("number", "paper", "here", "verdict", "why")


def page(template: str, record: Record, *, name: str, calibration: dict[str, Any]) -> str:
    """Fill the page's template.

    Args:
        template: With ``$`` placeholders.
        record: A ``paper.json``.
        name: Of its file, from the root of the repository.
        calibration: The record that ``hazbot calibrate`` left.
    """
    return Template(template).substitute(
        record=name,
        summary=summary_line(record),
        bases=markdown_table(BASIS_TITLES, basis_rows(record)),
        predictions=prediction_line(record),
        findings="\n\n".join(findings(record)),
        people=markdown_table(DIFFERENCES, difference_rows(calibration)),
        lines=markdown_table(LINES, line_rows(record), wordy=LINES),
        numbers=markdown_table(NUMBERS, number_rows(record), wordy=("where", "basis", "verdict")),
        missed=markdown_table(MISSED, missed_rows(record), wordy=("verdict", "why")),
    )


def csv_of_lines(record: Record) -> str:
    """Return every equation, table and figure as CSV."""
    titles = ("item", "what", "status", "note", "code")
    return csv_table(
        titles,
        [
            [*(line[name] for name in titles[:-1]), " ".join(line["code"])]
            for line in record["lines"]
        ],
    )


def csv_of_numbers(record: Record) -> str:
    """Return every reported number as CSV."""
    fields = (
        *("what", "source", "relation", "paper", "here", "tolerance", "unit", "basis"),
        *("verdict", "reason"),
    )
    return csv_table(fields, [[entry[name] for name in fields] for entry in record["numbers"]])


def findings(record: Record) -> list[str]:
    """Return what each section came to, under its title."""
    return [
        f"### {section['number']} {section['title']}\n\n" + "\n\n".join(section["text"])
        for section in record["sections"]
    ]


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
            shown_paper(entry),
            shown(entry["here"]),
            shown_tolerance(entry),
            shown_basis(entry["basis"]),
            entry["verdict"].partition(":")[0],
        )
        for entry in record["numbers"]
    ]


def missed_rows(record: Record) -> Rows:
    """Return a row for each number that is not reproduced, with the reason."""
    return [
        (
            f"{entry['what']} ({entry['source']})",
            shown_paper(entry),
            shown(entry["here"]),
            entry["verdict"].partition(":")[0],
            entry["reason"],
        )
        for entry in record["numbers"]
        if entry["verdict"] != "reproduced"
    ]
