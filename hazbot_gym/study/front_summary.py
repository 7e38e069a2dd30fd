"""Pareto fronts of families over their sweep parameters: points and hypervolume."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.evaluation.statistics.crossed_bootstrap import crossed_draws, crossed_estimate
from hazbot_gym.evaluation.statistics.hypervolume import (
    Front,
    Point,
    front_hypervolume,
    hypervolume_difference,
    pareto_set,
)
from hazbot_gym.evaluation.statistics.intervals import Estimate
from hazbot_gym.evaluation.statistics.pareto import AXES
from hazbot_gym.study.config import Fronts

if TYPE_CHECKING:
    import pandas as pd

    from hazbot_gym.core.state import Floats


def summarise_fronts(
    rows: pd.DataFrame, fronts: Fronts, *, resamples: int, confidence: float, seed: int
) -> dict[str, object]:
    """Return each family's points and hypervolume, with paired differences.

    Differences are from the first family, and from the family of the largest hypervolume.

    Args:
        rows: of one set, or of several, each resampled separately.
        fronts: the families and sets.
        resamples: of the bootstrap.
        confidence: nominal coverage of the intervals.
        seed: of the draws; all points of all fronts share those of the scenarios.
    """
    members = fronts.members
    policies = list(dict.fromkeys(policy for some in members.values() for policy in some))
    ordered = rows.sort_values("training_seed", kind="stable")
    grouped = {policy: ordered[ordered["policy"] == policy] for policy in policies}
    first = grouped[policies[0]]
    strata = first["scenario_set"][first["training_seed"] == 0]
    counts = [grouped[policy]["training_seed"].nunique() for policy in policies]
    drawn = crossed_draws(strata, counts, np.random.default_rng(seed), resamples=resamples)
    points = {
        policy: Point(*_scores(grouped[policy], count), draws=draws)
        for policy, count, draws in zip(policies, counts, drawn, strict=True)
    }
    families = {name: [points[each] for each in some] for name, some in members.items()}
    areas = {
        name: front_hypervolume(front, fronts.corner, confidence=confidence)
        for name, front in families.items()
    }
    reference = next(iter(families.values()))
    largest = families[max(areas, key=lambda name: areas[name].mean)]

    def less(front: Front, other: Front) -> Estimate:
        return hypervolume_difference(front, other, fronts.corner, confidence=confidence)

    return {
        name: {
            "points": _points(members[name], front, confidence),
            "hypervolume": areas[name],
            "difference": less(front, reference),
            "behind": less(front, largest),
        }
        for name, front in families.items()
    }


def _scores(rows: pd.DataFrame, seeds: int) -> tuple[Floats, Floats]:
    delay, discomfort = (rows[axis].to_numpy(float).reshape(seeds, -1) for axis in AXES)
    return delay, discomfort


def _points(policies: Sequence[str], front: Front, confidence: float) -> list[dict[str, object]]:
    """Return the score of each policy of a family, and whether it is Pareto-optimal within it."""
    scores = [
        [
            crossed_estimate(each, point.draws, confidence=confidence)
            for each in (point.delay, point.discomfort)
        ]
        for point in front
    ]
    is_best = pareto_set([[delay.mean, discomfort.mean] for delay, discomfort in scores])
    return [
        {"policy": policy, **dict(zip(AXES, each, strict=True)), "on_front": bool(best)}
        for policy, each, best in zip(policies, scores, is_best, strict=True)
    ]
