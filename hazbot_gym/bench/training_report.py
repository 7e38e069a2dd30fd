"""Training benchmark results, as tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Group

from hazbot_gym.bench import report
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import console_table, shown

Record = JsonObject

GOALS = ("run", "goal", "", "measured")

METRICS = {
    "delay_s": "delay, s",
    "discomfort_s": "discomfort, s",
    "return": "return",
    "arrived_percent": "arrived, %",
}
ANSWERS = ("dominated by the expert", "return above the expert's")
RUNS = ("run", "seed", "seconds", *METRICS.values(), *ANSWERS)


def table(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    machine = record["machine"]
    return Group(
        console_table(GOALS, list(goal_rows(record))),
        console_table(RUNS, list(run_rows(record))),
        f"{machine['processor']}, {machine['cores']} cores, "
        f"load {record['load_before']:.1f} before",
    )


def goal_rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Yield goals and measured values of each run."""
    for name, found in record["runs"].items():
        for row in report.goal_rows(found):
            yield name, *row


def run_rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Yield the expert and every seed of every run."""
    for name, found in record["runs"].items():
        yield name, "fuzzy expert", "", *_metrics(found["expert"]), "", ""
        for run in found["runs"]:
            answers = (_yes(run["is_dominated"]), _yes(run["is_better_paid"]))
            seconds = shown(run["seconds"])
            yield name, str(run["seed"]), seconds, *_metrics(run["metrics"]), *answers


def _metrics(metrics: Record) -> Iterator[str]:
    for name in METRICS:
        mean, low, high = (shown(metrics[name][each]) for each in ("mean", "low", "high"))
        yield f"{mean} ({low} to {high})"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
