"""Rows of text as a table on the terminal, right-aligned but for the first column."""

from __future__ import annotations

from collections.abc import Sequence

from hazbot_gym.utils.terminal import FittedTable

Rows = list[tuple[str, ...]]


def shown(value: float | None) -> str:
    """Format a number with three significant digits, None as a dash."""
    if value is None:
        return "-"
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 100 else f"{rounded:g}"


def console_table(
    titles: tuple[str, ...], rows: Rows, *, spare: Sequence[str] | None = None
) -> FittedTable:
    """Return rows as a table for the terminal; ``spare`` as in ``FittedTable``."""
    table = FittedTable(box=None, pad_edge=False, spare=spare)
    for place, title in enumerate(titles):
        table.add_column(title, justify="right" if place else "left")
    for row in rows:
        table.add_row(*row)
    return table
