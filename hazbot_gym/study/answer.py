"""One-sentence verdict: the sets in which a learned policy beats the reference.

A policy is better in a scenario set where the interval of its paired gain in return lies above 0,
and worse where it lies below 0; all other sets, such as those of a single scenario, are undecided.
Of several learned policies, the one with the largest return is compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.headline import headline, pooled_sets

LEARNED = ("learned", "ppo")  # learned policies of the register
_COMPARED = (
    ("time_ratio", "time ratio {:.3f} against {:.3f}", 1),
    ("kinetic_intrusion_m2", "kinetic intrusion {:.4f} against {:.4f} m²", 1),
    ("contact_robot_caused", "contacts by the robot {:.2f} against {:.2f} %", 100),
)


def answer(summary: Mapping[str, Any], study: StudyConfig) -> str:
    """Return the sentence that a study's summary supports."""
    reference, first = study.reference_policy, headline(summary)
    returns = {
        name: first.policies[name]["metrics"]["return"]["mean"]
        for name in learned(study)
        if name != reference
    }
    if not returns:
        return f"No learned policy was compared with {reference}."
    best = max(returns, key=lambda name: returns[name])
    ours, theirs = first.policies[best], first.policies[reference]
    gain = ours["return_gain"]
    interval = "no interval from a single scenario"
    if gain["low"] is not None:
        interval = f"{summary['confidence']:.0%} interval {gain['low']:.2f} to {gain['high']:.2f}"
    who = f"learned policy {best}"
    if len(returns) > 1:
        who = f"best of {len(returns)} learned policies, {best},"
    return (
        f"The {who} earns more return than {reference} in "
        f"{_where(summary, study, best)}; "
        f"{first.name}: return {gain['mean']:+.2f} ({interval}), "
        f"{', '.join(_metrics(ours['metrics'], theirs['metrics']))}."
    )


def learned(study: StudyConfig) -> list[str]:
    """Return the names of the policies of a study that were trained."""
    trained = {learner.name for learner in study.learners}
    return [name for name in study.names if name in trained or name.partition(":")[0] in LEARNED]


def _where(summary: Mapping[str, Any], study: StudyConfig, policy: str) -> str:
    """Return the sets with a gain over the reference, and the sets with a loss."""
    pooled = pooled_sets(study)
    gains = {
        name: block[policy]["return_gain"]
        for name, block in summary["sets"].items()
        if name not in pooled
    }
    known = {name: gain for name, gain in gains.items() if gain["low"] is not None}
    better = [name for name, gain in known.items() if gain["low"] > 0.0]
    worse = [name for name, gain in known.items() if gain["high"] < 0.0]
    parts = [f"{len(better)} of {len(gains)} set{'s' if len(gains) > 1 else ''}"]
    if 0 < len(better) < len(gains):
        parts[0] += f" ({', '.join(better)})"
    if worse:
        parts.append(f"less in {len(worse)} ({', '.join(worse)})")
    if len(gains) > len(better) + len(worse):
        single = len(gains) - len(known)
        note = f" ({single} with a single scenario)" if single else ""
        parts.append(f"undecided in {len(gains) - len(better) - len(worse)}{note}")
    return ", ".join(parts)


def _metrics(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> Iterator[str]:
    for metric, form, scale in _COMPARED:
        means = [each[metric]["mean"] for each in (ours, theirs)]
        if None not in means:
            yield form.format(*(scale * mean for mean in means))
