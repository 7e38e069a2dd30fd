"""Regret of policies relative to the oracle, scenario by scenario.

With J and T a policy's return and delay, J* and T* the same of the oracle in the same scenario, and
J_c the return of the best constant speed:

    regret            mean(J* - J)
    normalised        mean(J - J_c) / mean(J* - J_c)      0 the constant speed, 1 the oracle
    avoidable delay   mean(T - T*)

The avoidable delay stays in seconds: the oracle has the largest return and not the least delay, so
a share of another policy's can have a denominator near 0. Intervals come from the crossed
bootstrap; ratios are formed in every resample.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    crossed_draws,
    crossed_mean,
    each_once,
)
from hazbot_gym.evaluation.statistics.intervals import Estimate, ratio
from hazbot_gym.evaluation.statistics.pareto import AXES
from hazbot_gym.evaluation.statistics.student import student_interval

if TYPE_CHECKING:
    import pandas as pd

CONSTANT = "constant"


def regrets(
    rows: pd.DataFrame,
    best: pd.DataFrame,
    names: tuple[str, ...],
    *,
    resamples: int,
    confidence: float,
    seed: int,
) -> dict[str, object]:
    """Return each policy's regret relative to the oracle, and the oracle's own results.

    Args:
        rows: of the policies, in any scenarios.
        best: of the oracle, in the scenarios that count.
        names: of the policies.
        resamples: of the bootstrap.
        confidence: nominal coverage of the intervals.
        seed: of the draws.
    """
    scores = {name: _scores(rows[rows["policy"] == name], best) for name in names}
    seeds = [len(scores[name]["return"]) for name in names]
    rng = np.random.default_rng(seed)
    drawn = crossed_draws(best["scenario_set"], [*seeds, 1], rng, resamples=resamples)
    draws = dict(zip(names, drawn, strict=False))
    mark = {name: best[name].to_numpy(float)[None] for name in ("bound", "delay_s")}
    constants = [name for name in names if name.startswith(CONSTANT)]
    constant = max(constants, key=lambda name: scores[name]["return"].mean(), default=None)

    def over(name: str, metric: str, top: Floats) -> tuple[Floats, CrossedDraws]:
        return top - scores[name][metric], draws[name]

    def of(name: str) -> dict[str, Estimate]:
        found = {
            "regret": _estimate(confidence, over(name, "return", mark["bound"])),
            "avoidable_delay_s": _negative(
                _estimate(confidence, over(name, "delay_s", mark["delay_s"]))
            ),
        }
        if constant is not None:
            left = _estimate(
                confidence,
                over(name, "return", mark["bound"]),
                over(constant, "return", mark["bound"]),
            )
            found["normalised"] = _one_less(left)
        return found

    metrics = ("bound", *AXES)
    return {
        "episodes": len(best),
        "constant": constant,
        "best": {name: _mean(best[name]) for name in metrics},
        "policies": {name: of(name) for name in names},
    }


def _scores(rows: pd.DataFrame, best: pd.DataFrame) -> dict[str, Floats]:
    """Return a policy's scores (training seeds, scenarios) in the scenarios of the oracle."""
    keys = ["scenario_set", "episode"]
    table = rows.set_index([*keys, "training_seed"])[["return", "delay_s"]].unstack()
    mine = table.loc[list(best[keys].itertuples(index=False, name=None))]
    return {name: mine[name].to_numpy(float).T for name in ("return", "delay_s")}


def _estimate(
    confidence: float,
    numerator: tuple[Floats, CrossedDraws],
    denominator: tuple[Floats, CrossedDraws] | None = None,
) -> Estimate:
    """Estimate a mean, or a ratio of two means over the same draws of scenarios."""
    parts = [part for part in (numerator, denominator) if part is not None]
    once = [crossed_mean(scores, each_once(draws)) for scores, draws in parts]
    many = [crossed_mean(scores, draws) for scores, draws in parts]
    seeds = [draws.seeds for _, draws in parts]
    if denominator is None:
        return student_interval(float(once[0][0]), many[0], seeds, confidence=confidence)
    return student_interval(float(ratio(*once)[0]), ratio(*many), seeds, confidence=confidence)


def _negative(estimate: Estimate) -> Estimate:
    return Estimate(-estimate.mean, -estimate.high, -estimate.low)


def _one_less(estimate: Estimate) -> Estimate:
    return Estimate(1.0 - estimate.mean, 1.0 - estimate.high, 1.0 - estimate.low)


def _mean(values: pd.Series) -> float:
    return float(values.mean())
