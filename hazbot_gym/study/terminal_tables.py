"""Terminal tables of results: one per scenario set, with mean and interval in every cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.text import Text

from hazbot_gym.study.headline import headline, scenarios_of
from hazbot_gym.study.results import Metrics, OneResult, SetResults, Summary
from hazbot_gym.utils.terminal import FittedTable, printable


class Column(NamedTuple):
    """Format of a metric."""

    metric: str
    title: str
    scale: float = 1.0
    digits: int = 2
    finer: int = 0  # further digits if space allows, as in the report


COLUMNS = (
    Column("delay_s", "delay\ns", 1, 1, finer=1),
    Column("personal_m", "in the\npersonal\nzone, m", finer=1),
    Column("intimate_m", "in the\nintimate\nzone, m", finer=1),
    Column("person_delay_s", "people's\ndelay\ns", 1, 1, finer=1),
    Column("contacts_per_km", "contacts\nby robot\nper km", 1, 1, finer=1),
    Column("discomfort_s", "discomfort\ns", finer=1),
    Column("contact_person_caused", "contact\nby person\n%", 100, 0, finer=2),
    Column("arrived", "arrived\n%", 100, 0, finer=1),
    Column("return", "return", 1, 0, finer=1),
)
# In environments with gas, after the others.
GAS_COLUMNS = (
    Column("leak_found", "leaks\nfound\n%", 100, 0, finer=1),
    Column("false_alarms", "false\nalarms", finer=1),
    Column("time_to_alarm_s", "time to\nalarm\ns", 1, 1),
    Column("leak_error_m", "leak\nerror\nm", finer=1),
    Column("leak_error_corrected_m", "leak\nerror, no\nlag, m", finer=1),
)


# Columns dropped on a narrow terminal, in order.
SPARE = (
    "leak_error_corrected_m",
    "time_to_alarm_s",
    "contact_person_caused",
    "discomfort_s",
    "arrived",
    "intimate_m",
    "person_delay_s",
    "contacts_per_km",
    "personal_m",
    "leak_error_m",
    "false_alarms",
    "delay_s",
)


def study_tables(summary: Summary, *, is_verbose: bool = False) -> Group:
    """Return the headline's table, or the tables of every set and aggregate."""
    first = headline(summary)
    interval = f"{summary['confidence']:.0%} interval over scenarios"
    note = f"Below each mean: {interval}; none for a single scenario."
    shown = summary["sets"] if is_verbose else {first.name: first.policies}
    if len(first.sets) > 1:
        note += f" Pooled in {first.name!r}: {', '.join(first.sets)}."
    return Group(
        *(set_table(name, block) for name, block in shown.items()),
        Text(printable(note), style="dim"),
    )


def set_table(name: str, policies: Mapping[str, OneResult] | SetResults) -> FittedTable:
    """Return the table of one scenario set, one row per policy."""
    episodes, columns = scenarios_of(policies), columns_of(policies)
    table = FittedTable(
        title=f"{name}: {episodes} episode{'s' if episodes > 1 else ''} per policy",
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        expand=True,
        spare=[column.title for name in SPARE for column in columns if column.metric == name],
    )
    table.add_column("policy", overflow="fold", min_width=16)
    for column in columns:
        table.add_column(column.title, justify="right", no_wrap=True)
    for policy, result in policies.items():
        # A long name breaks after its colon, since each cell has two lines.
        shown = policy if len(policy) <= 16 else policy.replace(":", ":\n", 1)
        table.add_row(shown, *_cells(result["metrics"], columns))
    return table


def columns_of(policies: Mapping[str, OneResult] | SetResults) -> tuple[Column, ...]:
    """Return the columns of a set: those of gas only if its environment has gas."""
    leaks = [result["metrics"].get("leak") for result in policies.values()]
    has_gas = any(leak is not None and leak["mean"] is not None for leak in leaks)
    return (*COLUMNS, *GAS_COLUMNS) if has_gas else COLUMNS


def _cells(metrics: Metrics, columns: tuple[Column, ...]) -> Iterator[Text]:
    for column in columns:
        estimate = metrics[column.metric]
        mean, low, high = (_number(estimate[end], column) for end in ("mean", "low", "high"))
        yield Text.assemble(
            mean, "\n", ("" if estimate["low"] is None else f"{low}..{high}", "dim")
        )


def _number(value: float | None, column: Column) -> str:
    return "?" if value is None else f"{value * column.scale:z.{column.digits}f}"
