"""What the study was to show, declared before it ran, and whether it came out so.

The aims are those of the issue that asked for the study. Each is decided here from the record
alone; what does not come out is shown beside what does. An aim in a measure that is gone, the share
of the tuned expert's avoidable delay removed, is left out, which the page says.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from study_record import AXIS_TITLES, axes_of

from hazbot_gym.evaluation.statistics.pareto import dominates
from hazbot_gym.study.headline import TEST

Record = Mapping[str, Any]

PROBABILITY, NORMALISED_PERCENT = 0.95, 95.0
EXPERT, EXPERT_FRONT, DIRECTIONAL = "fuzzy_expert", "fuzzy_expert", "ssm:mode=directional"
LEARNED_FRONT = "residual ppo, three prices"


class Target(NamedTuple):
    """An aim, what was measured of it, and whether it was reached."""

    aim: str
    measured: str
    is_reached: bool


def tracks_targets(found: Record) -> list[Target]:
    """Return the targets of the tracks tier."""
    best, reference = best_learner(found), found["reference"]
    return [
        _no_higher(found, best, reference, *_axis(found, 1), 4),
        _no_higher(found, best, reference, "ssm_violation", "SSM violation", 5),
        _more_return(found, best, reference),
        _larger_front(found),
        _no_contacts(found, best),
        _near_the_optimum(found, best),
        _never_dominated(found, best),
    ]


def sonar_targets(found: Record) -> list[Target]:
    """Return the targets of the sonar tier."""
    best, block = best_learner(found), found["together"][TEST]
    against_expert = [
        _no_higher(found, best, EXPERT, *_axis(found, 0), 4),
        _no_higher(found, best, EXPERT, *_axis(found, 1), 4),
    ]
    blind = block[best]["percent"]["contact_robot_caused"]
    return [
        *against_expert,
        Target(
            "no contacts by the robot, as from the blind sectors",
            f"`{best}`: {blind['mean']:.2f} % ({blind['low']:.2f} to {blind['high']:.2f})",
            blind["mean"] == 0.0,
        ),
        _never_dominated(found, best),
    ]


def best_learner(found: Record) -> str:
    """Return the learner that the study file names first: what was best on validation before."""
    return str(found["learners"][0])


def _axis(found: Record, axis: int) -> tuple[str, str]:
    """Return the metric of an axis of the fronts, and its name."""
    metric = axes_of(found)[axis]
    return metric, AXIS_TITLES[metric].partition(",")[0]


def _no_higher(
    found: Record, best: str, reference: str, metric: str, name: str, digits: int
) -> Target:
    ours, theirs = (
        found["together"][TEST][policy]["metrics"][metric] for policy in (best, reference)
    )
    return Target(
        f"{name} no higher than of `{reference}`",
        f"`{best}`: {ours['mean']:.{digits}f} against {theirs['mean']:.{digits}f}",
        ours["mean"] <= theirs["mean"],
    )


def _more_return(found: Record, best: str, reference: str) -> Target:
    gain = found["together"][TEST][best]["return_gain"]
    likely = gain["probability"]
    return Target(
        f"more return than `{reference}`, probability of improvement at least {PROBABILITY}",
        f"`{best}`: {gain['mean']:.2f} ({gain['low']:.2f} to {gain['high']:.2f}) more; probability "
        f"{likely['mean']:.3f} ({likely['low']:.3f} to {likely['high']:.3f})",
        gain["low"] > 0.0 and likely["mean"] >= PROBABILITY,
    )


def _larger_front(found: Record) -> Target:
    fronts = found["fronts"]["together"]
    ours, theirs = (fronts[name]["hypervolume"] for name in (LEARNED_FRONT, EXPERT_FRONT))
    return Target(
        "a larger hypervolume than the fuzzy expert's, intervals apart",
        f"{ours['mean']:.4f} ({ours['low']:.4f} to {ours['high']:.4f}) against "
        f"{theirs['mean']:.4f} ({theirs['low']:.4f} to {theirs['high']:.4f})",
        ours["low"] > theirs["high"],
    )


def _no_contacts(found: Record, best: str) -> Target:
    block = found["together"][TEST][best]
    rate = block["percent"]["contact_robot_caused"]
    return Target(
        "no contact by the robot in the test episodes",
        f"`{best}`: {rate['mean']:.2f} % of {block['episodes']} episodes",
        rate["mean"] == 0.0,
    )


def _near_the_optimum(found: Record, best: str) -> Target:
    score = found["oracle"]["exact"]["policies"][best]["normalised"]
    return Target(
        "95 % of the span from the best constant speed to the exact optimum",
        f"`{best}`: {score['mean']:.1f} % ({score['low']:.1f} to {score['high']:.1f})",
        score["mean"] >= NORMALISED_PERCENT,
    )


def _never_dominated(found: Record, best: str) -> Target:
    groups = found["together"]
    where = [
        group
        for group, block in groups.items()
        if dominates(block[DIRECTIONAL]["metrics"], block[best]["metrics"], axes_of(found))
    ]
    return Target(
        f"in no group of scenarios dominated by `{DIRECTIONAL}`",
        f"`{best}`: " + (", ".join(where) if where else f"in none of {len(groups)}"),
        not where,
    )
