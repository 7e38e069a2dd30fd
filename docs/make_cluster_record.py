"""Measure a study on Ray clusters of one, two and three nodes of this machine.

``python docs/make_cluster_record.py`` writes ``benchmarks/cluster.json``; it needs Ray. What is
computed for other clusters rests on CPU time, which other work on the machine hardly changes.
"""

from __future__ import annotations

import math
import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ray.cluster_utils import Cluster

from hazbot_gym.evaluation.workers import Place, Pool
from hazbot_gym.study import store
from hazbot_gym.study.candidates import Candidate
from hazbot_gym.study.config import load_study
from hazbot_gym.study.run import plan, rehearse, rows_of
from hazbot_gym.study.stamps import Stamps
from hazbot_gym.study.summary import summarise
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json

RECORD = Path(__file__).parents[1] / "benchmarks" / "cluster.json"
NODES, TURNS, CALLS = (1, 2, 3), 3, 1000
POLICY = "fuzzy_expert"
STUDY = load_study(policies=[POLICY], sets=["Corridor"], episodes=1500, episodes_per_shard=250)
NODE = {"num_cpus": 1, "object_store_memory": 200_000_000}


def measure() -> dict[str, Any]:
    """Return the record."""
    rehearse(STUDY)
    nodes = {}
    with _cluster() as cluster:
        for count in NODES:
            if count > 1:
                cluster.add_node(**NODE)
                time.sleep(5.0)
            began = time.perf_counter()
            with Place(1, cluster.address).pool() as pool:
                _seconds(pool, math.sqrt, [(4.0,)])
                started = time.perf_counter() - began
                nodes[str(count)] = _rates(pool, count)
                busy = time.process_time()
                _seconds(pool, math.sqrt, [(4.0,)] * CALLS)
                calls = time.process_time() - busy
            nodes[str(count)] |= {"start_s": started, "call_s": calls / CALLS}
    with Place(2).pool() as pool:
        local = _rates(pool, 2)
    return {
        "machine": provenance.machine(),
        "versions": {**provenance.versions(), "ray": _ray_version()},
        "policy": POLICY,
        "episodes": STUDY.episodes,
        "episodes_per_shard": STUDY.episodes_per_shard,
        "turns": TURNS,
        "nodes": nodes,
        "local": local,
        "driver": _driver(),
    }


@contextmanager
def _cluster() -> Iterator[Cluster]:
    os.environ |= {"RAY_USAGE_STATS_ENABLED": "0", "RAY_worker_niceness": "0"}
    cluster = Cluster(initialize_head=True, head_node_args=NODE)
    yield cluster
    cluster.shutdown()


def _rates(pool: Pool, workers: int) -> dict[str, Any]:
    """Return the decisions per second of every turn, with all workers warm."""
    shards = [(each.work,) for each in plan(STUDY, Path(), [Candidate(POLICY, (POLICY,))])]
    _seconds(pool, _run, shards[:1] * 2 * workers)
    rates, of_a_core, decisions = [], [], 0
    for _ in range(TURNS):
        began = time.perf_counter()
        counts, seconds = zip(*_results(pool, _run, shards), strict=True)
        decisions = sum(counts)
        rates.append(round(decisions / (time.perf_counter() - began)))
        of_a_core.append(round(decisions / sum(seconds)))
    return {
        "decisions": decisions,
        "rates": rates,
        "rate": statistics.median(rates),
        "rate_of_a_core": statistics.median(of_a_core),
    }


def _run(shard: Any) -> tuple[int, float]:
    """Run a shard in a worker; return its decisions and seconds of CPU time."""
    began = time.process_time()
    decisions = sum(int(row["steps"]) for row in rows_of(shard))
    return decisions, time.process_time() - began


def _results(pool: Pool, function: Any, calls: list[tuple[Any, ...]]) -> Iterator[Any]:
    for future in as_completed([pool.submit(function, *arguments) for arguments in calls]):
        yield future.result()


def _seconds(pool: Pool, function: Any, calls: list[tuple[Any, ...]]) -> float:
    began = time.perf_counter()
    list(_results(pool, function, calls))
    return time.perf_counter() - began


def _driver() -> dict[str, float]:
    """Return the driver's seconds to write and read a shard, and to summarize an episode."""
    stamps = Stamps(STUDY)
    with tempfile.TemporaryDirectory() as folder:
        shards = list(plan(STUDY, Path(folder), [Candidate(POLICY, (POLICY,))], stamps))
        rows = [rows_of(shard.work) for shard in shards]
        began = time.process_time()
        for shard, part in zip(shards, rows, strict=True):
            stamps.check()
            store.write_rows(shard.path, part, shard.stamp)
        written = time.process_time() - began
        joined = store.join(
            [frame for shard in shards if not isinstance(frame := shard.read(), store.Missing)]
        )
        read = time.process_time() - began - written
        began = time.process_time()
        summarise(joined, STUDY)
        store.write_episodes(Path(folder) / store.EPISODES, joined)
        summed = time.process_time() - began
    return {
        "write_s": written / len(shards),
        "read_s": read / len(shards),
        "summary_s": summed / len(joined),
    }


def _ray_version() -> str:
    import ray

    return str(ray.__version__)


if __name__ == "__main__":
    write_json(RECORD, measure())
