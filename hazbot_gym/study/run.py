"""Study runner: several policies over the same scenarios, on all cores, resumable.

Episodes run in shards; a shard's rows depend on the shard alone, so that results depend neither on
the number of workers nor on interruptions.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import time
from collections import Counter
from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rich.console import Console

from hazbot_gym.evaluation.oracle.runs import OracleShard, run_oracle_shard
from hazbot_gym.evaluation.oracle.trajectory_search import Effort
from hazbot_gym.evaluation.rollout import Shard, run_shard, try_out
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.evaluation.workers import Place
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.study import candidates, costs, replays, store
from hazbot_gym.study.candidates import Candidate, Job
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.headline import pooled_sets
from hazbot_gym.study.results import Summary
from hazbot_gym.study.stamps import Stamps
from hazbot_gym.study.summary import summarise
from hazbot_gym.utils import files, processors, provenance, terminal
from hazbot_gym.utils.files import LONGEST
from hazbot_gym.utils.json_object import JsonObject

if TYPE_CHECKING:
    import pandas as pd


Rows = list[JsonObject]
SCENARIOS_PER_ORACLE_SHARD = 5  # an interruption costs at most half a minute


class StoredShard(NamedTuple):
    """A shard of episodes or oracle drives, and the file of its rows."""

    work: Shard | OracleShard
    path: Path
    stamp: str

    def read(self) -> pd.DataFrame | store.Missing:
        """Return the rows, or the reason of their absence."""
        return store.read_rows(self.path, rows=self.work.episodes, stamp=self.stamp)


Done = tuple[StoredShard, Rows]  # a shard that was run, and its rows


def run_study(
    study: StudyConfig,
    out: Path,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    console: Console | None = None,
    command: str = "",
    allowed: Permissions = NO_CODE,
) -> Summary:
    """Run the missing part of a study, write its files into ``out`` and return its summary.

    Args:
        study: what to run.
        out: folder of the results, new, empty or this study's own.
        workers: number of processes, or of threads for a single shard; None for one per core.
        cluster: address of a Ray cluster that runs the work, ``auto`` for the one of this machine;
            None for local processes. Results are the same.
        console: output of progress; None for silence.
        command: command line to reproduce the study, for the record.
        allowed: permissions of the study's policies.

    Raises:
        InvalidInput: the study or the folder is not usable; nothing was written.
    """
    console, began = console or Console(quiet=True), time.perf_counter()
    if cluster:  # whose workers find trained policies by paths from the working folder
        out = _from_here(out)
    store.claim(out, study.identity())
    about = manifest(study, rehearse(study, allowed))
    place = Place(workers or processors.usable(), cluster)
    with files.sole_use(out):
        return _run_study(study, out, about, place, console, command, began, allowed)


def _run_study(
    study: StudyConfig,
    out: Path,
    about: dict[str, object],
    place: Place,
    console: Console,
    command: str,
    began: float,
    allowed: Permissions,
) -> Summary:
    """Run the missing part of a study with a claimed folder; ``about`` is its manifest."""
    if not (out / store.MANIFEST).exists():
        files.write_json(out / store.MANIFEST, about)  # marks the owner of the folder
    stamps = Stamps(study, allowed)
    waiting = candidates.jobs(study, out, allowed, console)
    _prepare(waiting, place, console=console)
    policies = candidates.of_study(study, out)
    shards = list(plan(study, out, policies, stamps))
    marks = list(plan_oracle(study, out, policies, stamps))
    missing = _missing([*shards, *marks], console)
    if missing:
        store.withdraw(out)  # remove results of an earlier state before writing a new manifest
        about["candidates"] = candidates.portable(policies, out)
        files.write_json(out / store.MANIFEST, about)
    _run(missing, stamps, place, console=console)
    rows = store.join([_read(shard) for shard in shards])
    best = store.join([_read(shard) for shard in marks]) if marks else None
    summary = summarise(rows, study, best)
    store.write_episodes(out / store.EPISODES, rows)
    if best is not None:
        store.write_episodes(out / store.ORACLE, best)
    files.write_json(out / store.SUMMARY, summary)
    replays.record(
        study,
        out / store.REPLAYS,
        rows,
        best,
        {each.name: each.specs[0] for each in policies},
        stamp=_stamp_of([*shards, *marks], out / store.EPISODES),
        threads=place.processes,
        console=console,
        allowed=allowed,
    )
    seconds, decisions = time.perf_counter() - began, int(rows["steps"].sum())
    session = costs.Session(command, seconds, len(waiting), len(missing), decisions)
    trainings = candidates.trainings(study, out)
    costs.note(out / store.COSTS, trainings, session if waiting or missing else None)
    store.remove_partial(out)
    return summary


def plan(
    study: StudyConfig, out: Path, policies: list[Candidate], stamps: Stamps | None = None
) -> Iterator[StoredShard]:
    """Yield the shards of a study, grouped by scenario set.

    Policies of the fronts' sweeps only run in the fronts' sets.
    """
    stamps = stamps or Stamps(study)
    everywhere, swept = _specs(policies), _specs(candidates.swept(study))
    on_fronts = study.sets_named(study.fronts.sets) if study.fronts else ()
    for scenarios in study.all_sets:
        episodes, seed = study.episodes_in(scenarios), _seed(study, scenarios)
        for name, spec, training_seed in (
            *everywhere,
            *(swept if scenarios in on_fronts else ()),
        ):
            for first in range(0, episodes, study.episodes_per_shard):
                count = min(study.episodes_per_shard, episodes - first)
                shard = Shard(
                    name, scenarios, first, count, seed, study.ssm, study.engine, spec,
                    training_seed, stamps.allowed,
                )  # fmt: skip
                path = _file(out, "rows", name, scenarios, training_seed, first)
                values = {**shard._asdict(), "scenarios": None, "spec": "", "allowed": NO_CODE}
                yield StoredShard(shard, path, stamps.of(values, scenarios, spec))


def plan_oracle(
    study: StudyConfig, out: Path, policies: list[Candidate], stamps: Stamps | None = None
) -> Iterator[StoredShard]:
    """Yield the shards of oracle drives, few scenarios each since they are slow."""
    if study.oracle is None:
        return
    wanted = study.oracle
    specs = tuple(each.specs[0] for each in policies)
    stamps = stamps or Stamps(study)
    effort = Effort(wanted.worlds, wanted.rounds)
    for scenarios in study.sets_named(wanted.sets):
        episodes = min(wanted.episodes, study.episodes_in(scenarios))
        for first in range(0, episodes, SCENARIOS_PER_ORACLE_SHARD):
            count, seed = min(SCENARIOS_PER_ORACLE_SHARD, episodes - first), _seed(study, scenarios)
            shard = OracleShard(
                scenarios, first, count, seed, specs, effort, study.ssm, stamps.allowed
            )
            path = _file(out, "oracle", "best drive", scenarios, first)
            values = {**shard._asdict(), "scenarios": None, "specs": (), "allowed": NO_CODE}
            yield StoredShard(shard, path, stamps.of(values, scenarios, *specs))


def rehearse(study: StudyConfig, allowed: Permissions = NO_CODE) -> dict[str, object]:
    """Test every policy in every set, so that invalid input fails before any work.

    This also compiles the kernels once, before the workers load them from the cache.

    Returns:
        The resolved config of every set's environment.

    Raises:
        InvalidInput: a policy or an environment cannot be made, or they do not fit each other.
    """
    candidates.check(study, allowed)
    pooled_sets(study)
    return {
        scenarios.name: try_out(scenarios, study.policies, study.engine, allowed).model_dump(
            mode="json"
        )
        for scenarios in study.all_sets
    }


def manifest(study: StudyConfig, environments: dict[str, object]) -> dict[str, object]:
    """Return the provenance of a study."""
    return {
        "study": study.identity(),
        "config": study.model_dump(mode="json"),
        "environments": environments,
        "candidates": {policy: [policy] for policy in study.policies},
        "ssm_profile": study.ssm.profile(),
        "seed": study.seed,
        "versions": provenance.versions(),
        "commit": provenance.commit(),
        "machine": provenance.machine(),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def rows_of(shard: Shard | OracleShard, threads: int = 1) -> Rows:
    """Run a unit of work and return its rows."""
    if isinstance(shard, OracleShard):
        return run_oracle_shard(shard)
    return [dict(row) for row in run_shard(shard, threads)]


def _missing(shards: list[StoredShard], console: Console) -> list[StoredShard]:
    """Return the shards to run, and report kept and repeated shards."""
    states = [(shard, shard.read()) for shard in shards]
    missing = [shard for shard, state in states if isinstance(state, store.Missing)]
    reasons = Counter(state.reason for _, state in states if isinstance(state, store.Missing))
    if len(missing) < len(shards):
        console.print(f"{len(shards) - len(missing)} of {len(shards)} shards are done already")
    if reasons["damaged"]:
        console.print(f"{reasons['damaged']} damaged shards are run again")
    if reasons["outdated"]:
        console.print(f"{reasons['outdated']} shards of other code or data are run again")
    return missing


def _prepare(waiting: list[Job], place: Place, *, console: Console) -> None:
    """Run the tuning and training jobs."""
    if not waiting:
        return
    inputs = [path for job in waiting for path in job.files()]
    threads = ThreadPoolExecutor(len(waiting))  # each waits for the workers of its job
    with terminal.progress_bar(console) as progress, place.pool(inputs) as pool:
        task = progress.add_task("tuning and training", total=len(waiting))
        for future in as_completed([threads.submit(job.run, pool) for job in waiting]):
            future.result()
            progress.advance(task)


def _run(shards: list[StoredShard], stamps: Stamps, place: Place, *, console: Console) -> None:
    """Run shards and write each as soon as it is finished."""
    if not shards:
        return
    # Processes start slowly; a single shard uses the engine's threads instead.
    is_parallel = place.cluster or (len(shards) > 1 and place.processes > 1)
    run = _run_in_pool(shards, place, stamps) if is_parallel else _run_here(shards, place.processes)
    with terminal.progress_bar(console) as progress:
        task = progress.add_task("episodes", total=sum(shard.work.episodes for shard in shards))
        with contextlib.closing(run) as done:
            for shard, rows in done:
                stamps.check()
                store.write_rows(shard.path, rows, shard.stamp)
                progress.advance(task, shard.work.episodes)


def _run_here(shards: list[StoredShard], threads: int) -> Generator[Done]:
    """Yield shards and their rows, one after the other."""
    for shard in shards:
        yield shard, rows_of(shard.work, threads)


def _run_in_pool(shards: list[StoredShard], place: Place, stamps: Stamps) -> Generator[Done]:
    """Yield shards and their rows from parallel workers, in order of completion."""
    with place.pool(stamps.files()) as pool:
        running = {pool.submit(rows_of, shard.work): shard for shard in shards}
        for future in as_completed(running):
            yield running.pop(future), future.result()


def _from_here(path: Path) -> Path:
    """Return a path inside the working folder as a relative one."""
    here, absolute = Path.cwd(), Path(os.path.abspath(path))
    return absolute.relative_to(here) if absolute.is_relative_to(here) else path


def _read(shard: StoredShard) -> pd.DataFrame:
    rows = shard.read()
    if isinstance(rows, store.Missing):
        raise OSError(f"{shard.path} was {rows.reason} right after it was written")
    return rows


def _specs(policies: list[Candidate]) -> list[tuple[str, str, int]]:
    """Return name, spec and training-seed index of every policy."""
    return [
        (each.name, spec, training_seed)
        for each in policies
        for training_seed, spec in enumerate(each.specs)
    ]


def _stamp_of(shards: list[StoredShard], episodes: Path) -> str:
    """Return the stamp of the aggregated results: of all shards' stamps and of the rows."""
    parts = [*(shard.stamp for shard in shards), provenance.digest(episodes)]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def _seed(study: StudyConfig, scenarios: ScenarioSet) -> int:
    return study.seed if scenarios.seed is None else scenarios.seed


def _file(out: Path, kind: str, who: str, scenarios: ScenarioSet, *numbers: int) -> Path:
    """Return a unique file name with policy, set and first episode."""
    shown = "--".join([who, scenarios.name, *(f"{number:05d}" for number in numbers)])
    short = files.file_name(shown).encode()[:LONGEST].decode(errors="ignore")
    text = json.dumps([kind, who, scenarios.name, *numbers])  # unambiguous
    unique = hashlib.sha256(text.encode()).hexdigest()[:8]
    return out / store.SHARDS / f"{short}--{unique}.parquet"
