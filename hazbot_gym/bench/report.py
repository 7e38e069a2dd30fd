"""Benchmark results, as tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Group

from hazbot_gym.bench.cases import CARTPOLE, CORRIDOR
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

RATES = ("steps a second, median (quartiles)", "", "times CartPole-v1")
PARTS = ("part of a step in one of 1024 worlds, one thread", "microseconds")
GOALS = ("goal", "", "measured")
ONCE = ("measured once", "")


def table(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    machine = record["machine"]
    return Group(
        console_table(RATES, rate_rows(record)),
        console_table(PARTS, part_rows(record)),
        console_table(GOALS, goal_rows(record)),
        console_table(ONCE, once_rows(record)),
        f"{CORRIDOR} and the batched engine with {record[CORRIDOR]['with'].partition(' ')[2]}",
        f"{record['what']}; {record['turns']} turns",
        f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}, "
        f"load {record['load_before']:.1f} before",
        *record["notes"],
    )


def rate_rows(record: Record) -> Rows:
    """Return name, rate and ratio to CartPole-v1 of every case."""
    cases = {name: record[name] for name in (CARTPOLE, CORRIDOR)} | record["cases"]
    return [(name, *rate(case)) for name, case in cases.items()]


def rate(case: Record) -> tuple[str, str]:
    """Return the rate of a case with its quartiles, and its ratio to CartPole-v1."""
    low, high = (shown(value) for value in case["steps_per_s_quartiles"])
    return f"{shown(case['steps_per_s'])} ({low} to {high})", shown(case["to_cartpole"])


def part_rows(record: Record) -> Rows:
    """Return the time of each part of a step."""
    return [(name, shown(us)) for name, us in record["breakdown_us"].items()]


def goal_rows(record: Record) -> Rows:
    """Return goals and measured values."""
    rows: Rows = []
    for name, goal in record["goals"].items():
        side = "at least" if "at least" in goal else "at most"
        rows.append((name, f"{side} {shown(goal[side])}", shown(goal["measured"])))
    return rows


def once_rows(record: Record) -> Rows:
    """Return compile times, memory and the evaluation."""
    return list(_once(record))


def _once(record: Record) -> Iterator[tuple[str, str]]:
    for engine, found in record["compile"].items():
        low, high = (shown(value) for value in found["cached_s_quartiles"])
        cached = f"{shown(found['cached_s'])} s ({low} to {high})"
        cold = f", {shown(found['cold_s'])} s compiling" if "cold_s" in found else ""
        yield f"process to its first two episodes, {engine}", f"{cached} cached{cold}"
    memory = record["memory"]
    held = f"{shown(memory['bytes_a_world'])} bytes"
    grown = f"{shown(memory['growth_bytes_a_world'])} more after {memory['steps']} steps"
    yield f"a world of {memory['worlds']}, {memory['people']} people", f"{held}, {grown}"
    run = record["evaluation"]
    low, high = (shown(value) for value in run["seconds_quartiles"])
    taken = f"{shown(run['seconds'])} s ({low} to {high})"
    yield f"{run['episodes']} episodes of fuzzy_expert, records written", taken
