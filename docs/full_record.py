"""What pages read in the record of every algorithm, ``benchmarks/full.json``."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from pathlib import Path

from hazbot_gym.study.default_policies import family_of
from hazbot_gym.utils.json_object import JsonObject

FULL = Path(__file__).parents[1] / "benchmarks" / "full.json"
Record = JsonObject
REAL = {"real people, replay": "as recorded", "real people, seeded": "reactive"}


def headline(record: Record) -> Record:
    """Return the test scenarios of all environments together."""
    return record["sets"][record["headline"]]  # type: ignore[no-any-return]


def ahead_of_best_rule(record: Record) -> list[str]:
    """Return the learned policies with an interval above 0 over the best rule, best first."""
    gains, block = record["over_best_rule"], headline(record)
    return [
        policy
        for policy in ranked(block)
        if policy in learned_in(record) and gains[policy]["low"] > 0.0
    ]


def learned_in(record: Record) -> list[str]:
    """Return the learned policies in the test scenarios."""
    block = headline(record)
    return [policy for policy in block if policy not in record["rules"]]


def best_of_family(record: Record) -> list[str]:
    """Return the rule with the highest mean return of each family, and the reference."""
    block, best = headline(record), dict[str, str]()
    for rule in reversed(ranked({rule: block[rule] for rule in record["rules"]})):
        best[family_of(rule)] = rule
    return [record["reference"], *best.values()]


def means(found: Record) -> dict[str, float]:
    """Return the means of a policy's metrics."""
    return {name: estimate["mean"] for name, estimate in found["metrics"].items()}


def in_each_place(record: Record) -> Record:
    """Return the test scenarios of each environment, by its name."""
    first = f"{record['headline']}/"
    sets = record["sets"]
    return {name.removeprefix(first): sets[name] for name in sets if name.startswith(first)}


def ranked(block: Record) -> list[str]:
    """Return the policies of a set, the highest mean return first."""
    return sorted(block, key=lambda policy: -return_of(block[policy]))


def return_of(found: Record) -> float:
    """Return the mean return of a policy in a set."""
    return float(found["metrics"]["return"]["mean"])


def seconds(record: Record, policy: str) -> str:
    """Return the median time of a learner's trainings."""
    runs = record["runs"].get(policy, ())
    return f"{statistics.median(run['training_seconds'] for run in runs):.0f}" if runs else ""


def seeds_of(record: Record) -> int:
    """Return the number of seeds of each learner."""
    return len(next(iter(record["runs"].values())))


def named(policies: Iterable[str]) -> str:
    """Return policies as text, ``none`` for no policy."""
    return ", ".join(f"`{policy}`" for policy in policies) or "none"


def leader(block: Record, policies: Iterable[str]) -> str:
    """Return the policy with the highest mean return in a set, with its return."""
    best = max(policies, key=lambda policy: return_of(block[policy]))
    return f"`{best}` ({return_of(block[best]):.1f})"
