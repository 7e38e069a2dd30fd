"""Speed benchmark relative to Gymnasium's CartPole-v1 in the same run.

Absolute speeds depend on the machine, so that results are ratios. All cases are measured in turns,
so that other load on the machine affects all of them.
"""

from __future__ import annotations

import os
import statistics
import time
from typing import NamedTuple

from hazbot_gym.bench import once
from hazbot_gym.bench.cases import (
    CARTPOLE,
    CORRIDOR,
    ONE_THREAD,
    SHIPPED,
    WITH,
    WITH_GAS,
    WITHOUT_PEOPLE,
    WITHOUT_WHEELS,
    Case,
    asking,
    batched,
    make_cases,
)
from hazbot_gym.utils import provenance
from hazbot_gym.utils.json_object import JsonObject

EPISODES = 1000  # of the evaluation
Record = JsonObject


class Effort(NamedTuple):
    """Duration of the measurement."""

    turns: int
    turn_s: float  # time per case and turn [s]
    spread: int  # spread of episode steps between worlds of a batch
    evaluations: int
    memory_steps: int
    is_compiling: bool  # whether to measure compilation


FULL = Effort(9, 0.5, spread=300, evaluations=3, memory_steps=300, is_compiling=True)
QUICK = Effort(3, 0.1, spread=30, evaluations=1, memory_steps=30, is_compiling=False)


def bench(effort: Effort = FULL) -> Record:
    """Measure everything, and return medians and spreads, ratios and the machine."""
    load = os.getloadavg()[0]
    cases, notes = make_cases(effort.spread)
    rates = measure(cases, effort)
    rows = {name: _row(rates[name], rates[CARTPOLE]) for name in cases}
    measured = {
        "compile": once.compile_times(effort.is_compiling, effort.evaluations),
        "memory": once.memory(1024, 4, effort.memory_steps),
        "evaluation": once.evaluation(EPISODES, effort.evaluations),
    }
    return {
        CORRIDOR: {**rows.pop(CORRIDOR), "with": f"4 {WITH}"},
        CARTPOLE: rows.pop(CARTPOLE),
        "ratio": ratio(rates, CORRIDOR, CARTPOLE),
        "cases": rows,
        **measured,
        "breakdown_us": breakdown(rates),
        "goals": goals(rates, measured),
        "what": "random actions, resets included; the batched engine uses all cores",
        "turns": effort.turns,
        "notes": notes,
        "load_before": load,
        "machine": provenance.machine(),
    }


def measure(cases: dict[str, Case], effort: Effort) -> dict[str, list[float]]:
    """Return the steps per second of every case in every turn."""
    calls = {name: calls_for(case, effort.turn_s) for name, case in cases.items()}
    rates: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(effort.turns):
        for name, case in cases.items():
            rates[name].append(case.size * calls[name] / seconds(case, calls[name]))
    return rates


def calls_for(case: Case, turn_s: float) -> int:
    """Return the number of calls in about a turn's time."""
    case.run(1)  # compiles or loads kernels
    calls = 1
    while (taken := seconds(case, calls)) < 0.2 * turn_s:
        calls *= 4
    return max(1, round(calls * turn_s / taken))


def seconds(case: Case, calls: int) -> float:
    """Return the time of some calls [s]."""
    start = time.perf_counter()
    case.run(calls)
    return time.perf_counter() - start


def ratio(rates: dict[str, list[float]], name: str, other: str) -> float:
    """Return the speed ratio of two cases, the median over the turns."""
    return statistics.median(a / b for a, b in zip(rates[name], rates[other], strict=True))


def breakdown(rates: dict[str, list[float]]) -> Record:
    """Return the time of each part of a step per world, of 1024 on one thread [us], medians."""
    turns = zip(rates[ONE_THREAD], rates[WITHOUT_PEOPLE], rates[WITHOUT_WHEELS], strict=True)
    parts = [
        (1e6 / bare, 1e6 / empty - 1e6 / bare, 1e6 / full - 1e6 / empty)
        for full, empty, bare in turns
    ]
    rest, wheels, people = (statistics.median(part) for part in zip(*parts, strict=True))
    return {
        "four people: forces, and what sensors and contacts have to do with them": people,
        "wheel loops at 100 Hz on two motors, and their noise": wheels,
        "path, tracking, sensors on walls, observation, reward, resets, Python": rest,
    }


def goals(rates: dict[str, list[float]], measured: Record) -> Record:
    """Return goals with limit and measured value."""
    many = batched(1024, 4)
    found = {
        f"{many}, to {CARTPOLE}": ("at least", 9.0, ratio(rates, many, CARTPOLE)),
        f"{many}, to {CORRIDOR}": ("at least", 60.0, ratio(rates, many, CORRIDOR)),
        "batched, 1024 worlds, cost of 10 people to 0": (
            "at most",
            5.0,
            ratio(rates, batched(1024, 0), batched(1024, 10)),
        ),
        "batched, 4 people, 8192 worlds to 1024": (
            "at least",
            1.0,
            ratio(rates, batched(8192, 4), many),
        ),
        f"{WITH_GAS}, to the same without": ("at least", 0.7, ratio(rates, WITH_GAS, ONE_THREAD)),
        f"{asking(SHIPPED)}, to {many}": ("at least", 1.0, ratio(rates, asking(SHIPPED), many)),
        "memory, kB a world": ("at most", 16.0, measured["memory"]["bytes_a_world"] / 1000.0),
        "first episodes, cached, s": ("at most", 2.0, measured["compile"]["batched"]["cached_s"]),
    }
    if "cold_s" in measured["compile"]["batched"]:
        cold_s = measured["compile"]["batched"]["cold_s"]
        found["first episodes, compiling, s"] = ("at most", 40.0, cold_s)
    run_s = measured["evaluation"]["seconds"]
    found[f"evaluation, {EPISODES} episodes, s"] = ("at most", 5.0, run_s)
    return {name: {side: limit, "measured": value} for name, (side, limit, value) in found.items()}


def _row(rates: list[float], cartpole: list[float]) -> Record:
    return {
        **once.spread_of(rates, "steps_per_s"),
        "turns": len(rates),
        "to_cartpole": statistics.median(a / b for a, b in zip(rates, cartpole, strict=True)),
    }
