"""The pages on how PPO learns, in one environment and by choice, from their committed records."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from string import Template

import numpy as np
import numpy.typing as npt
from table_text import estimate_text, markdown_table

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import shown

Record = JsonObject
Curve = npt.NDArray[np.float64]

# Learners of ``configs/study_crossing.yaml`` by their names in the page's placeholders.
LEARNERS = {
    "ppo": "ppo from nothing",
    "qr_dqn": "qr-dqn from nothing",
    "own": "ppo from a qr-dqn of its own",
    "rule": "ppo from the rule",
}
DOORWAY = "Doorway-v1"
MORE = ("million actions", "all environments", DOORWAY, "the others", "delay, s")
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


def ablations(template: str, record: Record, *, name: str, more: Record) -> str:
    """Return the page on the choices of a training file; see ``page``.

    Args:
        template: With ``$`` placeholders.
        record: Of ``docs/keep_learning.py``.
        name: Of its file, from the root of the repository.
        more: Record of the choices that the training file does without.
    """
    return Template(template).substitute(
        _values(record),
        record=name,
        **{f"more_{key}": value for key, value in _values(more).items()},
    )


def from_nothing(
    template: str,
    record: Record,
    *,
    name: str,
    faster: Record | None = None,
    longer: Record | None = None,
) -> str:
    """Return the page on PPO from nothing with many seeds; see ``page``.

    Args:
        template: With ``$`` placeholders.
        record: Of ``docs/keep_learning.py``.
        name: Of its file, from the root of the repository.
        faster: Record of shorter trainings, if the page has them.
        longer: Record of longer trainings, if the page has them.
    """
    return Template(template).substitute(
        _values(record),
        record=name,
        **_seeds(record),
        **({} if faster is None else _faster(faster)),
        **({} if longer is None else _longer(longer)),
    )


def _seeds(record: Record) -> dict[str, str]:
    """Return the placeholders for the seeds of the one learner of a record."""
    ((learner, runs),) = record["runs"].items()
    seconds, returns = ([run[name] for run in runs] for name in ("training_seconds", "return"))
    expert = record["policies"][record["reference"]]["return"]["mean"]
    return {
        "median_s": f"{statistics.median(seconds):.0f}",
        "most_s": f"{max(seconds):.0f}",
        "above": str(sum(each > expert for each in returns)),
        "lowest": f"{min(returns):.1f}",
        "gains": ", ".join(
            f"`{rule}` {estimate_text(gain[learner])}" for rule, gain in record["gains"].items()
        ),
    }


def _faster(record: Record) -> dict[str, str]:
    """Return the placeholders for shorter trainings."""
    (runs,) = record["runs"].values()
    found = {**_values(record), **_seeds(record), "actions": f"{runs[0]['steps'][-1]:,}"}
    return {f"faster_{key}": value for key, value in found.items()}


def _longer(record: Record) -> dict[str, str]:
    """Return the placeholders for longer trainings: how they go on, and what they come to."""
    ((learner, runs),) = record["runs"].items()
    steps, curves = runs[0]["steps"], _mean_curves(runs)
    rows = [
        (f"{step / 1e6:.2f}", *(f"{curve[k]:.1f}" for curve in curves))
        for k, step in enumerate(steps)
    ]
    policies, doorway = record["policies"], curves[MORE.index(DOORWAY) - 1]
    return {
        "more_seeds": str(len(runs)),
        "more_actions": f"{steps[-1] / 1e6:.0f}",
        "more_s": f"{_seconds(runs):.0f}",
        "more_episodes": str(record["episodes"]),
        "more_return": estimate_text(policies[learner]["return"]),
        "more_rule": estimate_text(policies["mpc"]["return"]),
        "more_curve": markdown_table(MORE, rows),
        "more_first_doorway": f"{doorway[0]:.1f}",
        "more_last_doorway": f"{doorway[-1]:.1f}",
    }


def curves_of(run: Record) -> tuple[Curve, Curve, Curve]:
    """Return a run's returns in all environments, in a doorway, and the mean in the others."""
    others = [curve for env, curve in run["by_env"].items() if env != DOORWAY]
    return np.array(run["returns"]), np.array(run["by_env"][DOORWAY]), np.mean(others, axis=0)


def _mean_curves(runs: list[Record]) -> tuple[Curve, ...]:
    """Return means of all runs: those of ``curves_of``, and delays."""
    delays_s = [run["delays_s"] for run in runs]
    return tuple(
        np.mean(each, axis=0) for each in (*zip(*map(curves_of, runs), strict=True), delays_s)
    )


def _values(record: Record) -> dict[str, str]:
    return {
        "processor": record["machine"]["processor"],
        "episodes": str(record["episodes"]),
        "reference": record["reference"],
        "seeds": str(len(next(iter(record["runs"].values())))),
        "table": policies_table(record),
    }


def policies_table(record: Record) -> str:
    """Return a row for each policy, the highest return first."""
    return markdown_table(TITLES, list(_rows(record)))


def _rows(record: Record) -> Iterator[tuple[str, ...]]:
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
