"""One-time benchmarks: compile time, memory, and an evaluation."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np

from hazbot_gym.bench.cases import with_people
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.errors import MissingExtra
from hazbot_gym.evaluation.rollout import Shard, run_shard
from hazbot_gym.evaluation.scenario_set import DEFAULT_SETS
from hazbot_gym.utils import processors
from hazbot_gym.utils.json_object import JsonObject

WARM_UP = 250  # steps before memory is counted
MIXED = next(scenarios for scenarios in DEFAULT_SETS if scenarios.name == "Corridor")
FIRST_EPISODE = """
import time
start = time.perf_counter()
from hazbot_gym.evaluation import rollout
rollout.evaluate("fuzzy_expert", "hazbot_gym/Corridor-v1", episodes=2, engine={engine!r})
print(time.perf_counter() - start)
"""
Measured = JsonObject


def spread_of(values: list[float], name: str) -> Measured:
    """Return the median and the quartiles of repeated measurements."""
    low, median, high = np.percentile(values, [25, 50, 75])
    return {name: float(median), f"{name}_quartiles": [float(low), float(high)]}


def compile_times(with_cold: bool, turns: int) -> Measured:
    """Measure the time of a fresh process from its imports to the end of two episodes [s].

    Args:
        with_cold: whether to measure compilation from an empty cache folder.
        turns: number of starts with a full cache.
    """
    found: Measured = {}
    for engine in ("batched", "pymunk"):
        with tempfile.TemporaryDirectory() as folder:
            cache = {"NUMBA_CACHE_DIR": folder} if with_cold else {}
            cold_s = first_episode_s(engine, cache)
            cached = [first_episode_s(engine, cache) for _ in range(turns)]
        found[engine] = {
            **({"cold_s": cold_s} if with_cold else {}),
            **spread_of(cached, "cached_s"),
            "turns": turns,
        }
    return found


def first_episode_s(engine: str, environment: dict[str, str]) -> float:
    """Return the time of a fresh process for its first two episodes [s]."""
    command = [sys.executable, "-P", "-c", FIRST_EPISODE.format(engine=engine)]
    done = subprocess.run(
        command,
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        check=True,
    )
    return float(done.stdout)


def memory(worlds: int, people: int, steps: int) -> Measured:
    """Measure the memory of a world [bytes], and its growth after some steps."""
    few = CorridorVectorEnv(1, **with_people(people))  # loads kernels before the count starts
    few.reset(seed=0)
    few.step(np.zeros((1, 1), np.float32))
    tracemalloc.start()
    try:
        envs = CorridorVectorEnv(worlds, **with_people(people))
        envs.reset(seed=0)
        actions = np.zeros((worlds, 1), np.float32)
        for _ in range(WARM_UP):  # warm-up: threads start, and free lists fill
            envs.step(actions)
        at_first = traced_bytes()
        for _ in range(steps):
            envs.step(actions)
        later = traced_bytes()
    finally:
        tracemalloc.stop()
    return {
        "worlds": worlds,
        "people": people,
        "bytes_a_world": at_first / worlds,
        "steps": steps,
        "growth_bytes_a_world": (later - at_first) / worlds,
    }


def traced_bytes() -> int:
    """Return the memory that Python's objects hold, since ``tracemalloc`` was started."""
    gc.collect()  # cycles that wait for it are no growth
    sys._clear_type_cache()  # nor are names in Python's own cache of attributes, some 100 kB
    return tracemalloc.get_traced_memory()[0]


def evaluation(episodes: int, turns: int) -> Measured:
    """Measure the time of an evaluation of the fuzzy expert, with records [s]."""
    shard = Shard("fuzzy_expert", MIXED, first=0, episodes=episodes, seed=0)
    run_shard(shard._replace(episodes=2))  # compiles or loads kernels
    seconds = []
    for _ in range(turns):
        start = time.perf_counter()
        rows = run_shard(shard, threads=processors.usable())
        note = _write(rows)
        seconds.append(time.perf_counter() - start)
    steps = sum(int(row["steps"]) for row in rows)
    return {"episodes": episodes, "steps": steps, **spread_of(seconds, "seconds"), **note}


def _write(rows: list[Any]) -> Measured:
    try:
        from hazbot_gym.study import store
    except MissingExtra as error:
        return {"note": f"no records written: {error}"}
    with tempfile.TemporaryDirectory() as folder:
        store.write_rows(Path(folder, "rows.parquet"), rows, stamp="bench")
    return {}
