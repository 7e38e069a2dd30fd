"""How fast policies learn, as tables on the terminal and as a page of the documentation."""

from __future__ import annotations

from collections.abc import Iterator
from string import Template
from typing import Any

from rich.console import Group

from hazbot_gym.study.plain_tables import console_table, markdown_table, shown

Record = dict[str, Any]

GOALS = ("run", "goal", "", "measured")
RUNS = ("run", "seed", "seconds", "time ratio", "kinetic intrusion, m²", "return", "arrived, %",
        "dominated by the expert", "return above the expert's")  # fmt: skip
SECONDS, RATE, TIMES, BYTES = 60.0, 50_000, 8.0, 1.5e9


def table(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    machine = record["machine"]
    return Group(
        console_table(GOALS, list(goal_rows(record))),
        console_table(RUNS, list(run_rows(record))),
        f"{machine['processor']}, {machine['cores']} cores, "
        f"load {record['load_before']:.1f} before",
    )


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page on training: a template with its placeholders filled in."""
    tables = {
        "goals": markdown_table(GOALS, list(goal_rows(record))),
        "runs": markdown_table(RUNS, list(run_rows(record))),
    }
    plain = {"record": name, "episodes": record["episodes"], "commit": record["commit"]}
    return Template(template).substitute(tables, **plain, **record["machine"])


def goal_rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Yield what was to be reached by each run, and what was measured."""
    for name, found in record["runs"].items():
        runs, speed = found["runs"], found["speed"]
        steps = f"{runs[0]['steps']:,}"
        free = sum(not run["is_dominated"] for run in runs)
        paid = sum(run["is_better_paid"] for run in runs)
        peak = max(run["peak_bytes"] for run in runs)
        yield name, "decisions a second", f"at least {RATE:,}", shown(speed["batched"])
        yield (
            name, "times the same PPO on 8 pymunk environments", f"at least {TIMES:g}",
            shown(speed["ratio"]),
        )  # fmt: skip
        yield (
            name, f"seconds of the whole command, {steps} decisions, median",
            f"at most {SECONDS:g}", shown(found["seconds"]),
        )  # fmt: skip
        yield name, "seeds not dominated by the fuzzy expert", "most", f"{free} of {len(runs)}"
        yield name, "seeds with a return above the expert's", "", f"{paid} of {len(runs)}"
        yield name, "peak memory, GB", f"at most {BYTES / 1e9:g}", shown(peak / 1e9)


def run_rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Yield the expert and every seed of every run."""
    for name, found in record["runs"].items():
        yield name, "fuzzy expert", "", *_metrics(found["expert"]), "", ""
        for run in found["runs"]:
            answers = (_yes(run["is_dominated"]), _yes(run["is_better_paid"]))
            seconds = shown(run["seconds"])
            yield name, str(run["seed"]), seconds, *_metrics(run["metrics"]), *answers


def _metrics(metrics: Record) -> Iterator[str]:
    for name in ("time_ratio", "kinetic_intrusion_m2", "return", "arrived"):
        scale = 100.0 if name == "arrived" else 1.0
        mean, low, high = (shown(scale * metrics[name][each]) for each in ("mean", "low", "high"))
        yield f"{mean} ({low} to {high})"


def _yes(value: bool) -> str:
    return "yes" if value else "no"
