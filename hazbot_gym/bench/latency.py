"""Latency benchmark: time of a ``SpeedController``'s answers, each policy in a fresh process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from typing import Any

import numpy as np

from hazbot_gym.runtime.controller import SpeedController
from hazbot_gym.runtime.people import Person
from hazbot_gym.utils import provenance
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

CASES = (
    ("constant", "sonar"),
    ("ssm:mode=strict", "tracks"),
    ("fuzzy_expert", "tracks"),
    ("fuzzy_expert", "sonar"),
    ("mpc", "tracks"),
    ("ppo", "tracks"),
    ("ppo", "sonar"),
)
STEPS, QUICK_STEPS = 10_000, 300
MOST_PEOPLE = 5
TITLES = (
    "policy",
    "tier",
    "construction, s",
    "first, ms",
    "p50, ms",
    "p99, ms",
    "largest, ms",
    "p99 of CPU time, ms",
)
MEASURE = "import sys; from hazbot_gym.bench.latency import main; main(*sys.argv[1:])"
Record = JsonObject


def bench_latency(steps: int = STEPS) -> Record:
    """Measure all cases, and return them with the machine."""
    load = os.getloadavg()[0]
    return {
        "cases": [_in_a_process(policy, tier, steps) for policy, tier in CASES],
        "steps": steps,
        "people": f"0 to {MOST_PEOPLE}",
        "load_before": load,
        "machine": provenance.machine(),
    }


def _in_a_process(policy: str, tier: str, steps: int) -> Record:
    done = subprocess.run(
        [sys.executable, "-P", "-c", MEASURE, policy, tier, str(steps)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        check=True,
    )
    found: Record = json.loads(done.stdout)
    return {"policy": policy, "tier": tier, **found}


def main(policy: str, tier: str, steps: str) -> None:
    """Print the times of one case as JSON."""
    print(json.dumps(measure(policy, tier, int(steps))))


def measure(policy: str, tier: str, steps: int) -> Record:
    """Return the time to make a controller [s], and of its answers [ms]."""
    start = time.perf_counter()
    controller = SpeedController(policy, tier=tier)
    ready_s = time.perf_counter() - start
    rng = np.random.default_rng(0)
    taken_ms, cpu_ms = [], []
    for _ in range(steps):
        readings = draw(rng, len(controller.layout.sensors))
        start, cpu_start = time.perf_counter(), time.thread_time()
        controller.step(**readings)
        taken_ms.append(1e3 * (time.perf_counter() - start))
        cpu_ms.append(1e3 * (time.thread_time() - cpu_start))
    p50, p99 = np.percentile(taken_ms, [50, 99])
    return {
        "ready_s": ready_s,
        "first_ms": taken_ms[0],
        "p50_ms": float(p50),
        "p99_ms": float(p99),
        "max_ms": max(taken_ms),
        "cpu_p99_ms": float(np.percentile(cpu_ms, 99)),
    }


def draw(rng: np.random.Generator, sensors: int) -> dict[str, Any]:
    """Return random readings of a robot among people."""
    people = [
        Person(
            x_m=rng.uniform(-5.0, 5.0),
            y_m=rng.uniform(-5.0, 5.0),
            vx_mps=rng.uniform(-1.5, 1.5),
            vy_mps=rng.uniform(-1.5, 1.5),
            track=k,
        )
        for k in range(rng.integers(MOST_PEOPLE + 1))
    ]
    return {
        "ranges_m": rng.uniform(0.3, 4.0, sensors).tolist(),
        "speed_mps": rng.uniform(0.0, 0.5),
        "yaw_rate_radps": rng.uniform(-0.2, 0.2),
        "x_e_m": rng.uniform(-0.05, 0.05),
        "y_e_m": rng.uniform(-0.05, 0.05),
        "theta_e_rad": rng.uniform(-0.1, 0.1),
        "remaining_m": rng.uniform(0.0, 12.0),
        "curvature_ahead_per_m": 0.0,
        "people": people,
    }


def rows(record: Record) -> Rows:
    """Return a row of text for each case."""
    names = ("ready_s", "first_ms", "p50_ms", "p99_ms", "max_ms", "cpu_p99_ms")
    return [
        (case["policy"], case["tier"], *(shown(case[name]) for name in names))
        for case in record["cases"]
    ]


def table(record: Record) -> Any:
    """Return a record as a table for the terminal."""
    return console_table(TITLES, rows(record))
