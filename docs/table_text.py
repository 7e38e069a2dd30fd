"""Tables and estimates as text, for the pages that records make."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence

from hazbot_gym.utils.text_tables import Rows


def markdown_table(titles: tuple[str, ...], rows: Rows, *, wordy: tuple[str, ...] = ()) -> str:
    """Return rows in Markdown; the first column and those titled in ``wordy`` are left-aligned."""
    rule = ["---", *["---" if title in wordy else "---:" for title in titles[1:]]]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (titles, rule, *rows))


def estimate_text(estimate: Mapping[str, float], digits: int = 1, *, scale: float = 1.0) -> str:
    """Return a mean with its interval, as ``1.9 (-1.6 to 5.4)``."""
    mean, low, high = (f"{scale * estimate[end]:z.{digits}f}" for end in ("mean", "low", "high"))
    return f"{mean} ({low} to {high})"


def verdict(gain: Mapping[str, float]) -> str:
    """Return how a paired difference in return compares with zero, by its interval."""
    if gain["high"] < 0.0:
        return "earns less than"
    if gain["low"] > 0.0:
        return "earns more than"
    return "does not clearly earn more than"


def csv_table(titles: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return rows as CSV with a line of titles; None is an empty cell."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(titles)
    out.writerows(rows)
    return text.getvalue()
