"""One-sentence verdict: the sets in which a learned policy beats the reference.

A policy is better in a scenario set where the interval of its paired gain in return lies above 0,
and worse where it lies below 0; all other sets, such as those of a single scenario, are undecided.
Of several learned policies, the one with the largest return is compared.
"""

from __future__ import annotations

from collections.abc import Iterator

from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.headline import headline, pooled_sets
from hazbot_gym.study.results import Metrics, SetResults, Summary, mean_return

LEARNED = ("learned", "ppo")  # learned policies of the register
_COMPARED = (
    ("delay_s", "the delay {:.2f} against {:.2f} s"),
    ("personal_m", "the distance driven inside the personal zone {:.2f} against {:.2f} m"),
    ("contacts_per_km", "contacts by the robot per kilometre {:.2f} against {:.2f}"),
)


def answer(summary: Summary, study: StudyConfig) -> str:
    """Return the sentence that a study's summary supports."""
    best = _best_learned(summary, study)
    if best is None:
        return f"No learned policy was compared with {study.reference_policy}."
    where = _where(summary, study, best)
    return f"{_claim(study, best)} in {where}; {_figures(summary, study, best)}."


def verdict(summary: Summary, study: StudyConfig) -> list[str]:
    """Return the verdict in three sentences: the sets, the figures, and the Pareto optima."""
    best = _best_learned(summary, study)
    last = _optimal(headline(summary).policies)
    if best is None:
        return [answer(summary, study), *last]
    where = f"{_claim(study, best)} in {_where(summary, study, best)}."
    figures = _figures(summary, study, best)
    return [where, f"{figures[0].upper()}{figures[1:]}.", *last]


def pareto_optimal(policies: SetResults) -> list[str]:
    """Return the Pareto-optimal policies of a set; empty if that is undefined."""
    return [policy for policy, result in policies.items() if result["dominated_by"] == []]


def _optimal(policies: SetResults) -> list[str]:
    """Return the sentence on Pareto-optimal policies, by the shorter list; none if undefined."""
    optimal = pareto_optimal(policies)
    dominated = [policy for policy, result in policies.items() if result["dominated_by"]]
    named = ", ".join(optimal)
    if len(dominated) < len(optimal) == len(policies) - len(dominated):
        named = f"all {len(policies)} policies"
        if dominated:
            named += f" but {', '.join(dominated)}"
    return [f"Pareto-optimal in delay and discomfort: {named}."] if optimal else []


def _best_learned(summary: Summary, study: StudyConfig) -> str | None:
    """Return the learned policy with the largest return, if there is one beside the reference."""
    policies = headline(summary).policies
    returns = {name: mean_return(policies[name]) for name in _rivals(study)}
    return max(returns, key=lambda name: returns[name], default=None)


def _rivals(study: StudyConfig) -> list[str]:
    return [name for name in learned(study) if name != study.reference_policy]


def _claim(study: StudyConfig, best: str) -> str:
    count = len(_rivals(study))
    who = f"best of {count} learned policies, {best}," if count > 1 else f"learned policy {best}"
    return f"The {who} has a higher return than {study.reference_policy}"


def _figures(summary: Summary, study: StudyConfig, best: str) -> str:
    """Return the gain in return with its interval, and both policies' headline metrics."""
    first = headline(summary)
    ours, theirs = first.policies[best], first.policies[study.reference_policy]
    gain = ours["return_gain"]
    interval = "no interval from a single scenario"
    if gain["low"] is not None:
        interval = f"{summary['confidence']:.0%} interval {gain['low']:.2f} to {gain['high']:.2f}"
    difference = f"{first.name}: the difference in return is {gain['mean']:+.2f} ({interval})"
    return ", ".join([difference, *_metrics(ours["metrics"], theirs["metrics"])])


def learned(study: StudyConfig) -> list[str]:
    """Return the names of the policies of a study that were trained."""
    trained = {learner.name for learner in study.learners}
    return [name for name in study.names if name in trained or name.partition(":")[0] in LEARNED]


def _where(summary: Summary, study: StudyConfig, policy: str) -> str:
    """Return the sets with a gain over the reference, and the sets with a loss."""
    pooled = pooled_sets(study)
    gains = {
        name: block[policy]["return_gain"]
        for name, block in summary["sets"].items()
        if name not in pooled
    }
    known = {
        name: (low, high)
        for name, gain in gains.items()
        if (low := gain["low"]) is not None and (high := gain["high"]) is not None
    }
    better = [name for name, (low, _) in known.items() if low > 0.0]
    worse = [name for name, (_, high) in known.items() if high < 0.0]
    parts = [f"{len(better)} of {len(gains)} scenario set{'s' if len(gains) > 1 else ''}"]
    if 0 < len(better) < len(gains):
        parts[0] += f" ({', '.join(better)})"
    if worse:
        parts.append(f"a lower one in {len(worse)} ({', '.join(worse)})")
    if len(gains) > len(better) + len(worse):
        single = len(gains) - len(known)
        note = f" ({single} with a single scenario)" if single else ""
        parts.append(f"undecided in {len(gains) - len(better) - len(worse)}{note}")
    return ", ".join(parts)


def _metrics(ours: Metrics, theirs: Metrics) -> Iterator[str]:
    for metric, form in _COMPARED:
        our, their = ours[metric]["mean"], theirs[metric]["mean"]
        if our is not None and their is not None:
            yield form.format(our, their)
