"""The pages on how PPO learns, in one environment and by choice, from their committed records."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from string import Template

from table_text import estimate_text, markdown_table

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import shown

Record = JsonObject

# Learners of ``configs/study_crossing.yaml`` by their names in the page's placeholders.
LEARNERS = {
    "ppo": "ppo from nothing",
    "qr_dqn": "qr-dqn from nothing",
    "own": "ppo from a qr-dqn of its own",
    "rule": "ppo from the rule",
}
TITLES = (
    "policy",
    "return",
    "difference",
    "delay, s",
    "discomfort, s",
    "arrived, %",
    "contacts/km",
    "training, s",
)


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page on one environment: a template with its placeholders filled in.

    Args:
        template: With ``$`` placeholders.
        record: Of ``docs/keep_learning.py``.
        name: Of its file, from the root of the repository.
    """
    policies = record["policies"]
    delays = {key: policies[learner]["delay_s"] for key, learner in LEARNERS.items()}
    delays["rule"] = policies[record["reference"]]["delay_s"]
    gains = {key: policies[learner]["return_gain"] for key, learner in LEARNERS.items()}
    return Template(template).substitute(
        _values(record),
        record=name,
        **{f"delay_{key}": shown(delay["mean"]) for key, delay in delays.items()},
        **{f"gain_{key}": estimate_text(gain) for key, gain in gains.items()},
    )


def ablations(template: str, record: Record, *, name: str) -> str:
    """Return the page on the choices of a training file; see ``page``."""
    return Template(template).substitute(_values(record), record=name)


def from_nothing(template: str, record: Record, *, name: str) -> str:
    """Return the page on PPO from nothing with many seeds; see ``page``."""
    ((learner, runs),) = record["runs"].items()
    seconds, returns = ([run[name] for run in runs] for name in ("training_seconds", "return"))
    expert = record["policies"][record["reference"]]["return"]["mean"]
    return Template(template).substitute(
        _values(record),
        record=name,
        median_s=f"{statistics.median(seconds):.0f}",
        most_s=f"{max(seconds):.0f}",
        above=sum(each > expert for each in returns),
        lowest=f"{min(returns):.1f}",
        gains=", ".join(
            f"`{rule}` {estimate_text(gain[learner])}" for rule, gain in record["gains"].items()
        ),
    )


def _values(record: Record) -> dict[str, str]:
    return {
        "processor": record["machine"]["processor"],
        "episodes": str(record["episodes"]),
        "reference": record["reference"],
        "seeds": str(len(next(iter(record["runs"].values())))),
        "table": markdown_table(TITLES, list(_rows(record))),
    }


def _rows(record: Record) -> Iterator[tuple[str, ...]]:
    """Yield a row for each policy, the highest return first."""
    policies, runs = record["policies"], record["runs"]
    for policy in sorted(policies, key=lambda each: -policies[each]["return"]["mean"]):
        found = policies[policy]
        gain = found["return_gain"]
        yield (
            policy if policy in runs else f"`{policy}`",
            estimate_text(found["return"]),
            "" if policy == record["reference"] or gain is None else estimate_text(gain),
            shown(found["delay_s"]["mean"]),
            shown(found["discomfort_s"]["mean"]),
            shown(100.0 * found["arrived"]["mean"]),
            shown(found["contacts_per_km"]["mean"]),
            f"{_seconds(runs[policy]):.0f}" if policy in runs else "",
        )


def _seconds(runs: list[Record]) -> float:
    """Return the median time of a training."""
    return float(statistics.median(run["training_seconds"] for run in runs))
