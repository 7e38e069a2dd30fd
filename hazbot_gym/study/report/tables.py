"""Report tables: every number with its interval, the best of each column marked."""

from __future__ import annotations

from typing import NamedTuple

from hazbot_gym.study.results import Difference, Interval, SetResults
from hazbot_gym.study.summary import COMPARED
from hazbot_gym.study.terminal_tables import COLUMNS, GAS_COLUMNS, Column, columns_of

ELSEWHERE = "contact_person_caused"  # terminal column that only the full tables have
# Columns of the tables; the last one is in the differences, where a ratio of sums has no pairs.
KNOWN = {
    column.metric: column
    for column in (
        *COLUMNS,
        *GAS_COLUMNS,
        Column("contact_robot_caused", "contacts\nby robot\n%", 100, 0, finer=2),
    )
}
MORE_IS_BETTER = ("arrived", "leak_found", "return")
UNKNOWN = "?"
LEAST_P = 0.001  # shown; smaller ones depend on tails that no number of scenarios confirms
NAMED = 3  # of dominating policies


class Cell(NamedTuple):
    """A mean with its interval, as text."""

    mean: str
    interval: str
    is_best: bool = False


class Line(NamedTuple):
    """A row of a table."""

    name: str
    cells: list[Cell]


class Table(NamedTuple):
    """A table whose rows are policies or metrics."""

    head: list[str]
    lines: list[Line]


def headline(block: SetResults, policies: tuple[str, ...]) -> Table:
    """Return the table of headline metrics, one row per policy."""
    columns = [column for column in columns_of(block) if column.metric != ELSEWHERE]
    best = {column.metric: _best(block, column) for column in columns}
    lines = [
        Line(
            policy,
            [
                _cell(
                    block[policy]["metrics"][column.metric],
                    column,
                    is_best=policy in best[column.metric],
                )
                for column in columns
            ],
        )
        for policy in policies
    ]
    return Table([_title(column) for column in columns], lines)


def all_metrics(block: SetResults, policies: tuple[str, ...]) -> Table:
    """Return the table of all metrics, one row per metric."""
    names = list(block[policies[0]]["metrics"])
    first = [name for name in KNOWN if name in names]
    lines = []
    for name in [*first, *(other for other in names if other not in KNOWN)]:
        column = KNOWN.get(name)
        estimates = [block[policy]["metrics"][name] for policy in policies]
        lines.append(
            Line(_title(column) if column else name, [_cell(each, column) for each in estimates])
        )
    return Table(list(policies), lines)


def differences(block: SetResults, policies: tuple[str, ...], reference: str) -> Table:
    """Return the table of paired differences from the reference policy, on the same scenarios."""
    columns = [KNOWN[metric] for metric in COMPARED]
    lines = [
        Line(
            policy,
            [_compared(block[policy]["difference"][column.metric], column) for column in columns],
        )
        for policy in policies
        if policy != reference
    ]
    return Table([_title(column) for column in columns], lines)


def dominated(block: SetResults) -> dict[str, str]:
    """Return the dominated policies of a set, each with its dominating policies as text."""
    return {policy: _some(by) for policy, each in block.items() if (by := each["dominated_by"])}


def _some(names: list[str]) -> str:
    """Return the first names of a list, and the number of omitted ones."""
    shown, more = names[:NAMED], len(names) - NAMED
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def _title(column: Column) -> str:
    return column.title.replace("\n", " ")


def _digits(column: Column) -> int:
    return column.digits + column.finer


def _best(block: SetResults, column: Column) -> set[str]:
    """Return the policies with the best mean at the displayed precision."""
    sign = -1.0 if column.metric in MORE_IS_BETTER else 1.0
    means = {policy: result["metrics"][column.metric]["mean"] for policy, result in block.items()}
    shown = {
        policy: sign * round(mean * column.scale, _digits(column))
        for policy, mean in means.items()
        if mean is not None
    }
    return {policy for policy, value in shown.items() if value == min(shown.values())}


def _cell(estimate: Interval, column: Column | None, *, is_best: bool = False) -> Cell:
    mean, low, high = (_number(estimate[end], column) for end in ("mean", "low", "high"))
    return Cell(mean, "" if UNKNOWN in (low, high) else f"{low} to {high}", is_best)


def _compared(difference: Difference, column: Column) -> Cell:
    """Return a difference with its interval and its corrected p-value."""
    cell, p = _cell(difference, column), difference["p_holm"]
    return cell if p is None else cell._replace(interval=f"{cell.interval}; p {p_text(p)}")


def p_text(p: float) -> str:
    """Return a p-value with its sign of equality, or its bound if it is very small."""
    return f"< {LEAST_P:g}" if p < LEAST_P else f"= {p:.2g}"


def _number(value: float | None, column: Column | None) -> str:
    if value is None:
        return UNKNOWN
    if column is None:
        return f"{value:.3g}"
    return f"{value * column.scale:z.{_digits(column)}f}"
