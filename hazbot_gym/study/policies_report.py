"""How the shipped policies compare, as a page of the documentation."""

from __future__ import annotations

from collections.abc import Mapping
from string import Template
from typing import Any

from hazbot_gym.study.fronts import AXES, dominated
from hazbot_gym.study.plain_tables import Rows, markdown_table, shown
from hazbot_gym.study.summary import COMPARED, POOLED

Record = dict[str, Any]

RATES = ("arrived", "contact_robot_caused")
KEPT = (*RATES, *AXES, "ssm_violation", "rms_jerk_mps3", "return")
TITLES = (
    "policy", "arrived, %", "contacts by robot, %", "time ratio", "kinetic intrusion, m²",
    "SSM violation", "RMS jerk, m/s³", "return",
)  # fmt: skip
DIFFERENCES = ("ppo minus fuzzy_expert", "mean", "interval")
SETS = ("scenarios", "policy", "arrived, %", "contacts by robot, %", "time ratio",
        "kinetic intrusion, m²", "return")  # fmt: skip
PAIR = ("fuzzy_expert", "ppo")


def record_of(summaries: Mapping[str, Record]) -> Record:
    """Return what the page needs of the summaries of the studies, by tier."""
    return {
        tier: {
            "confidence": summary["confidence"],
            "study": summary["study"],
            "sets": {
                name: {
                    policy: _kept(found)
                    for policy, found in policies.items()
                    if name == POOLED or policy in PAIR
                }
                for name, policies in summary["sets"].items()
            },
        }
        for tier, summary in summaries.items()
    }


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page on policies: a template with its placeholders filled in."""
    filled = {"record": name}
    for tier, found in record.items():
        pooled = found["sets"][POOLED]
        filled |= {
            f"{tier}_pooled": markdown_table(TITLES, pooled_rows(pooled)),
            f"{tier}_dominated": _who_is_dominated(pooled),
            f"{tier}_difference": markdown_table(DIFFERENCES, difference_rows(pooled)),
            f"{tier}_sets": markdown_table(SETS, set_rows(found["sets"])),
            f"{tier}_episodes": str(pooled[PAIR[0]]["episodes"]),
        }
    return Template(template).substitute(filled)


def pooled_rows(policies: Record) -> Rows:
    """Return every policy's means over all sets, with their intervals."""
    return [
        (f"`{policy}`", *(_estimate(found["metrics"][metric], metric) for metric in KEPT))
        for policy, found in policies.items()
    ]


def difference_rows(policies: Record) -> Rows:
    """Return how PPO differs from the fuzzy expert on the same scenarios."""
    return [
        (metric, shown(each["mean"]), f"{shown(each['low'])} to {shown(each['high'])}")
        for metric, each in policies[PAIR[1]]["difference"].items()
    ]


def set_rows(sets: Record) -> Rows:
    """Return the two policies in every set."""
    metrics = (*RATES, *AXES, "return")
    return [
        (name, policy, *(_estimate(sets[name][policy]["metrics"][each], each) for each in metrics))
        for name in sets
        if name != POOLED
        for policy in PAIR
    ]


def _kept(found: Record) -> Record:
    return {
        "episodes": found["episodes"],
        "metrics": {name: found["metrics"][name] for name in KEPT},
        "percent": {name: _percent(found["metrics"][name]) for name in RATES},
        "difference": {name: found["difference"][name] for name in COMPARED},
    }


def _percent(estimate: Record) -> Record:
    return {name: 100.0 * value for name, value in estimate.items()}


def _estimate(estimate: Record, metric: str) -> str:
    values = _percent(estimate) if metric in RATES else estimate
    return f"{shown(values['mean'])} ({shown(values['low'])} to {shown(values['high'])})"


def _who_is_dominated(policies: Record) -> str:
    lines = [
        f"- `{policy}` by {', '.join(f'`{other}`' for other in by)}"
        for policy, by in dominated(policies).items()
        if by
    ]
    return "\n".join(lines) or "- nobody"
