"""Simulate how often intervals with few training seeds cover: ``python docs/make_coverage.py``.

Scores of R seeds in N scenarios are the sum of an effect of the seed, of the scenario, and of the
run; the true mean is 0. Two policies that are compared share an effect of the scenario, and each
has one of its own. Writes ``benchmarks/coverage.json``; three to four minutes on one core.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    crossed_draws,
    crossed_mean,
    each_once,
)
from hazbot_gym.evaluation.statistics.intervals import Estimate, percentile_interval
from hazbot_gym.evaluation.statistics.student import precision, student_interval, t_quantile
from hazbot_gym.utils.files import write_json

RECORD = Path(__file__).parents[1] / "benchmarks" / "coverage.json"
STUDIES, SCENARIOS, RESAMPLES, SEEDS = 1000, 200, 1000, (1, 2, 3, 5, 10)
DRAWN_FOR = 20  # studies that share their draws, which do not depend on the scores
CONFIDENCE = 0.95


class Model(NamedTuple):
    """Standard deviations of the effects on a score."""

    seed: float
    scenario: float
    own: float = 0.2  # of the scenario, on one policy alone
    run: float = 0.3
    is_skewed: bool = False  # effects of scenarios are exponential, not normal


MODELS = {
    "scenarios dominate": Model(0.1, 0.5),
    "seeds dominate": Model(0.5, 0.5),
    "seeds dominate, skewed scenarios": Model(0.5, 0.5, own=0.5, is_skewed=True),
}


class Sample(NamedTuple):
    """Scores of the compared policies, all of them or one, each (R, N), with their draws."""

    scores: list[Floats]
    draws: list[CrossedDraws]

    def means(self, draws: list[CrossedDraws]) -> Floats:
        """Return the mean, or the difference of two, of each resample."""
        each = [crossed_mean(*pair) for pair in zip(self.scores, draws, strict=True)]
        return each[0] - each[1] if len(each) == 2 else each[0]


def sample(model: Model, draws: list[CrossedDraws], rng: np.random.Generator) -> Sample:
    """Draw the scores of one policy, or of two in the same scenarios.

    A single seed has no effect: the interval is about that policy itself.
    """
    seeds, scenarios = draws[0].seeds.shape[1], draws[0].scenarios.shape[1]

    def by_scenario(deviation: float) -> Floats:
        if model.is_skewed:
            return rng.exponential(deviation, (scenarios,)) - deviation
        return rng.normal(0.0, deviation, (scenarios,))

    shared = by_scenario(model.scenario)
    scores = [
        shared
        + by_scenario(model.own)
        + rng.normal(0.0, model.seed * (seeds > 1), (seeds, 1))
        + rng.normal(0.0, model.run, (seeds, scenarios))
        for _ in draws
    ]
    return Sample(scores, draws)


def intervals(made: Sample) -> dict[str, Estimate]:
    """Return the interval of each method."""
    resampled = made.means(made.draws)
    value = float(made.means([each_once(draws) for draws in made.draws])[0])
    seeds = [draws.seeds for draws in made.draws]
    return {
        "percentile": percentile_interval(value, resampled, confidence=CONFIDENCE),
        "expanded": expanded(value, resampled, seeds),
        "studentised": studentised(made, value, resampled),
        "student": student_interval(value, resampled, seeds, confidence=CONFIDENCE),
    }


def expanded(value: float, resampled: Floats, seeds: list[Floats]) -> Estimate:
    """Return the percentile interval at Hesterberg's wider levels."""
    inflation, freedom = precision(resampled, seeds)
    z = inflation * t_quantile((1.0 + CONFIDENCE) / 2.0, freedom)
    return percentile_interval(value, resampled, confidence=math.erf(z / math.sqrt(2.0)))


def studentised(made: Sample, value: float, resampled: Floats) -> Estimate:
    """Return the bootstrap-t interval, for which each resample has its standard error."""
    error = standard_errors(made, made.draws, resampled)
    own = standard_errors(made, [each_once(draws) for draws in made.draws], np.array([value]))[0]
    t = (resampled - value)[error > 0.0] / error[error > 0.0]
    low, high = np.quantile(t, [(1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0])
    return Estimate(value, value - high * own, value - low * own)


def standard_errors(made: Sample, draws: list[CrossedDraws], means: Floats) -> Floats:
    """Return the standard error of each resample: of scenarios, and of each policy's seeds."""
    scenarios = made.scores[0].shape[1]
    columns, variance = np.zeros((len(means), scenarios)), np.zeros(len(means))
    for sign, scores, drawn in zip((1.0, -1.0), made.scores, draws, strict=False):
        seeds = len(scores)
        columns += sign * (drawn.seeds @ scores) / seeds
        if seeds > 1:
            rows = drawn.scenarios @ scores.T / scenarios
            centre = (drawn.seeds * rows).sum(axis=1, keepdims=True) / seeds
            spread = (drawn.seeds * (rows - centre) ** 2).sum(axis=1)
            variance += spread / (seeds * (seeds - 1))
    spread = (draws[0].scenarios * (columns - means[:, None]) ** 2).sum(axis=1)
    errors: Floats = np.sqrt(variance + spread / (scenarios * (scenarios - 1)))
    return errors


def coverage(
    model: Model, policies: int, seeds: int, *, studies: int = STUDIES, resamples: int = RESAMPLES
) -> dict[str, dict[str, float]]:
    """Return the share of intervals with the true value 0, and the median width, by method."""
    rng = np.random.default_rng(0)
    found: list[dict[str, Estimate]] = []
    for study in range(studies):
        if study % DRAWN_FOR == 0:
            strata, counts = np.zeros(SCENARIOS), [seeds] * policies
            draws = crossed_draws(strata, counts, rng, resamples=resamples)
        found.append(intervals(sample(model, draws, rng)))
    return {
        method: {
            "coverage": float(
                np.mean([each[method].low <= 0.0 <= each[method].high for each in found])
            ),
            "width": float(np.median([each[method].high - each[method].low for each in found])),
        }
        for method in found[0]
    }


def record() -> dict[str, Any]:
    """Return the record of all cases."""
    cases = itertools.product(MODELS, ("mean", "difference"), SEEDS)
    return {
        "studies": STUDIES,
        "scenarios": SCENARIOS,
        "resamples": RESAMPLES,
        "confidence": CONFIDENCE,
        "models": {name: model._asdict() for name, model in MODELS.items()},
        "cases": [
            {
                "model": name,
                "statistic": statistic,
                "seeds": seeds,
                "methods": coverage(MODELS[name], 1 + (statistic == "difference"), seeds),
            }
            for name, statistic, seeds in cases
        ],
    }


if __name__ == "__main__":
    write_json(RECORD, record())
