from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skfuzzy
from skfuzzy import control

from hazbot_gym.core.fuzzy import CENTROID_POINTS, SpeedRules, kept_fraction, kept_fractions
from hazbot_gym.core.state import Floats
from hazbot_gym.policies.fuzzy_expert import (
    AVOIDANCE_M,
    DISTANCE_TERMS,
    KEPT_TERMS,
    KEPT_WIDTH,
    PATTERN_TERMS,
    PATTERN_WIDTH,
    RULES,
    SPEED_TERMS,
    FuzzyExpert,
)
from hazbot_gym.policies.fuzzy_readings import FuzzyReading
from hazbot_gym.policies.fuzzy_system import control_system

# Every pair of inputs is on this grid: distances by speeds by patterns, 10,000 points.
DISTANCES_M, SPEEDS_MPS = np.linspace(1.2, 3.3, 50), np.linspace(0.0, 2.0, 50)
GRID = tuple(
    axis.ravel() for axis in np.meshgrid(DISTANCES_M, SPEEDS_MPS, np.arange(4), indexing="ij")
)
# Points at which scikit-fuzzy's control system is asked itself: distance, speed, pattern.
POINTS = [(1.7, 0.5, 1), (2.3, 0.9, 0), (2.6, 1.1, 2), (2.9, 0.8, 3), (2.1, 1.0, 1)]


def ours(controller: SpeedRules) -> Floats:
    """Return the compiled controller's answers on the grid."""
    distance, speed, pattern = (axis[:, None] for axis in GRID)
    return kept_fractions(distance, speed, pattern.astype(np.int64), controller)


def weights(expert: FuzzyExpert) -> Floats:
    """Return the weights of the rules on the grid by scikit-fuzzy: (rules, points)."""
    distance, speed, pattern = GRID
    terms = {
        name: skfuzzy.gauss2mf(values, c, s_left, c, s_right)
        for table, values in ((DISTANCE_TERMS, distance), (SPEED_TERMS, speed))
        for name, (c, s_left, s_right) in table.items()
    }
    for code, name in enumerate(PATTERN_TERMS):
        is_crisp = expert.controller.pattern_width == 0.0
        bell = skfuzzy.gaussmf(pattern, code, PATTERN_WIDTH)
        terms[name] = (pattern == code).astype(float) if is_crisp else bell
    join = np.multiply if expert.t_norm == "product" else np.fmin
    return np.array(
        [join(join(terms[r], terms[v]), terms[b]) for r, v, b, _ in RULES[expert.rules]]
    )


def outputs(expert: FuzzyExpert) -> Floats:
    return np.array([KEPT_TERMS[out] for *_, out in RULES[expert.rules]])


def within_limits(kept: Floats, controller: SpeedRules) -> Floats:
    """Return the answer of the rules between R_s and R_max, 0 nearer and 1 farther."""
    kept = np.where(GRID[0] <= controller.sensitive_m, 0.0, kept)
    return np.where(GRID[0] > controller.avoidance_m, 1.0, kept)


@pytest.mark.parametrize("t_norm", ["min", "product"])
@pytest.mark.parametrize("pattern", ["crisp", "gaussian"])
@pytest.mark.parametrize("rules", ["complete32", "literal8"])
def test_answers_on_the_grid_are_equation_9_over_scikit_fuzzy_s_memberships(
    t_norm: Any, pattern: Any, rules: Any
) -> None:
    expert = FuzzyExpert(rules=rules, pattern=pattern, t_norm=t_norm)
    w = weights(expert)
    total = w.sum(axis=0)
    mean = np.divide(outputs(expert) @ w, total, out=np.ones_like(total), where=total >= 1e-12)

    found = ours(expert.controller)
    assert found == pytest.approx(within_limits(mean, expert.controller), abs=1e-9)
    assert ((found > 0.1) & (found < 0.9)).any()


def test_centroid_on_the_grid_is_that_of_scikit_fuzzy() -> None:
    # Ours takes the integrals at 101 points by the trapezoidal rule, scikit-fuzzy those of the
    # polygon through the same points.
    reading = FuzzyReading(reading="centroid")
    universe = np.linspace(0.0, 1.0, CENTROID_POINTS)
    shapes = np.array([skfuzzy.gaussmf(universe, out, KEPT_WIDTH) for out in outputs(reading)])
    w = weights(reading)
    clipped = np.zeros((w.shape[1], len(universe)))
    for weight, shape in zip(w, shapes, strict=True):  # implication by minimum, union by maximum
        clipped = np.fmax(clipped, np.fmin(weight[:, None], shape))
    chosen = np.flatnonzero(GRID[0] <= AVOIDANCE_M)
    centroids = [skfuzzy.defuzz(universe, clipped[k], "centroid") for k in chosen]

    assert ours(reading.controller)[chosen] == pytest.approx(centroids, abs=5e-4)
    assert min(centroids) > 0.05


@pytest.mark.parametrize("t_norm", ["min", "product"])
@pytest.mark.parametrize("pattern", ["crisp", "gaussian"])
@pytest.mark.parametrize("rules", ["complete32", "literal8"])
def test_control_system_fires_the_same_rules(t_norm: Any, pattern: Any, rules: Any) -> None:
    # It interpolates memberships on universes of 601 points, hence the tolerance.
    expert = FuzzyExpert(rules=rules, pattern=pattern, t_norm=t_norm)
    system = control_system(expert)
    for distance, speed, code in POINTS:
        simulation = asked(system, distance, speed, code)
        fired = [rule.aggregate_firing[simulation] for rule in system.rules]
        total = sum(fired)
        kept = np.dot(fired, outputs(expert)) / total if total >= 1e-12 else 1.0
        found = kept_fraction(distance, speed, code, expert.controller)
        assert found == pytest.approx(kept, abs=0.002)


def test_control_system_s_answer_is_the_centroid() -> None:
    reading = FuzzyReading(reading="centroid")
    system = control_system(reading)
    for distance, speed, code in POINTS:
        kept = asked(system, distance, speed, code).output["kept"]
        assert kept_fraction(distance, speed, code, reading.controller) == pytest.approx(
            kept, abs=0.002
        )
        mean = kept_fraction(distance, speed, code, FuzzyExpert().controller)
        assert abs(mean - kept) < 0.21


def asked(system: Any, distance: float, speed: float, code: int) -> Any:
    """Return the simulation of the control system after an inference."""
    simulation = control.ControlSystemSimulation(system)
    for name, value in (("distance", distance), ("speed", speed), ("pattern", code)):
        simulation.input[name] = value
    simulation.compute()
    return simulation
