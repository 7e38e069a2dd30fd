"""Rows of text as a table on the terminal or in Markdown; all columns but the first flush right."""

from __future__ import annotations

from rich.table import Table

Rows = list[tuple[str, ...]]


def shown(value: float | None) -> str:
    """Return a number with three digits that count, a dash for none."""
    if value is None:
        return "-"
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 100 else f"{rounded:g}"


def console_table(titles: tuple[str, ...], rows: Rows) -> Table:
    """Return rows as a table for the terminal."""
    table = Table(box=None, pad_edge=False)
    for place, title in enumerate(titles):
        table.add_column(title, justify="right" if place else "left")
    for row in rows:
        table.add_row(*row)
    return table


def markdown_table(titles: tuple[str, ...], rows: Rows, *, wordy: tuple[str, ...] = ()) -> str:
    """Return rows as a table in Markdown; columns of words, named by title, are flush left too."""
    rule = ["---", *["---" if title in wordy else "---:" for title in titles[1:]]]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (titles, rule, *rows))
