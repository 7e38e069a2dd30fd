"""Hyperparameter tuning of rule families on the bank's validation scenarios, with equal budgets.

Trial 0 has the default options, so that tuning cannot make a family worse. Each trial is saved
before the next one begins, and each proposal depends on the trials before it alone
(``proposals.py``), so that a killed search resumes with the same results.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation import inputs, rollout
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.evaluation.workers import Here, Pool
from hazbot_gym.policies import base
from hazbot_gym.policies.tuning_spaces import SPACES, Interval, Space
from hazbot_gym.study import bank_sets
from hazbot_gym.study.proposals import Distribution, Trial, choice, interval, propose
from hazbot_gym.utils import files, provenance
from hazbot_gym.utils.json_object import JsonObject

FIRST_AT_RANDOM = 10  # random trials before the estimator starts
AT_A_BOUND = 0.02  # share of a range within which the best value counts as at its bound

Record = JsonObject


def validation(overrides: Mapping[str, object] | None = None) -> tuple[ScenarioSet, ...]:
    """Return the bank's validation sets, with optional overrides."""
    found = bank_sets.select("validation", overrides)
    return tuple(ScenarioSet.model_validate(each) for each in found)


VALIDATION = validation()


class Search(NamedTuple):
    """All values that determine a search's result."""

    family: str  # a name of ``SPACES``
    trials: int = 50
    seed: int = 0
    episodes: int = bank_sets.FEW  # in every set, at most the set's own
    sets: tuple[ScenarioSet, ...] = VALIDATION

    def identity(self) -> str:
        """Return a hash that is equal for equal searches with equal code."""
        sets = [each.model_dump(mode="json") for each in self.sets]
        read = [inputs.mark(inputs.of_set(each)) for each in self.sets]
        text = json.dumps([*self[:-1], sets, read, provenance.stamp()])
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def tune(
    search: Search,
    path: Path,
    *,
    pool: Pool | None = None,
    threads: int = 1,
    on_progress: Callable[[], None] = lambda: None,
) -> Record:
    """Run the remaining trials of a search, and return its record.

    Args:
        search: The search.
        path: File of the record; a record of the same search is resumed.
        pool: Workers, which run the scenario sets of a trial in parallel; None for this process.
        threads: Number of threads of each; results do not depend on it.
        on_progress: Called after each trial.

    Raises:
        InvalidInput: There is no such family, or the file holds another search or is read-only.
    """
    space = _space_of(search.family)
    files.check_writable(path)
    trials = _known_trials(path, search)
    while len(trials) < search.trials:
        number = len(trials)
        options = _next_options(space, trials, search.seed) if number else defaults(search.family)
        policy = base.spec_of(search.family, options)
        trials.append(
            {"policy": policy, "options": options, **judge(policy, search, pool, threads)}
        )
        files.write_json(path, _record(search, trials))
        on_progress()
    return _record(search, trials)


def _space_of(family: str) -> Space:
    if family not in SPACES:
        raise InvalidInput(f"tune: given {family!r}, allowed are {', '.join(SPACES)}")
    return SPACES[family]


def defaults(family: str) -> dict[str, object]:
    """Return the default values of the tunable options."""
    fields = {each.name: each.default for each in dataclasses.fields(base.factory_of(family))}
    return {name: _as_text(fields[name]) for name in SPACES[family]}


def _as_text(value: object) -> object:
    return str(value).lower() if isinstance(value, bool) else value


def _distributions(space: Space) -> dict[str, Distribution]:
    return {
        name: interval(*bounds) if isinstance(bounds, Interval) else choice(bounds)
        for name, bounds in space.items()
    }


def _next_options(space: Space, trials: list[Record], seed: int) -> dict[str, object]:
    """Return the next trial's options, a pure function of the previous trials and the seed."""
    tried = [Trial(trial["options"], trial["return"]) for trial in trials]
    return propose(_distributions(space), tried, seed, first_at_random=FIRST_AT_RANDOM)


def judge(
    policy: str, search: Search, pool: Pool | None = None, threads: int = 1
) -> dict[str, float | None]:
    """Return the headline metrics of a policy over all validation scenarios."""
    pool = pool or Here()
    shards = [
        rollout.Shard(
            policy, each, 0, min(search.episodes, each.episodes or search.episodes), each.seed or 0
        )
        for each in search.sets
    ]
    running = [pool.submit(rollout.run_shard, shard, threads) for shard in shards]
    return means([row for rows in running for row in rows.result()])


def _record(search: Search, trials: list[Record]) -> Record:
    best = max(trials, key=lambda trial: trial["return"])
    bounds = SPACES[search.family]
    return {
        "tuning": search.identity(),
        "family": search.family,
        "planned": search.trials,
        "best": best,
        "at_a_bound": [
            name
            for name, value in best["options"].items()
            if isinstance(each := bounds[name], Interval)
            and min(value - each.low, each.high - value) < AT_A_BOUND * (each.high - each.low)
        ],
        "trials": trials,
    }


def found(search: Search, path: Path) -> list[Record] | None:
    """Return the trials in a search's file; None if the file holds another search."""
    if not path.exists():
        return []
    try:
        record = files.read_json(path)
        return list(record["trials"]) if record["tuning"] == search.identity() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _known_trials(path: Path, search: Search) -> list[Record]:
    trials = found(search, path)
    if trials is None:
        raise InvalidInput(
            f"tune: {str(path)!r} is damaged, or holds another search or something else; remove it "
            "or give a new file"
        )
    return trials
