"""The paper's fuzzy strategy as a control system of scikit-fuzzy, for plots and tests."""

from __future__ import annotations

import numpy as np

from hazbot_gym.errors import MissingExtra
from hazbot_gym.policies.fuzzy_expert import (
    DISTANCE_TERMS,
    KEPT_TERMS,
    KEPT_WIDTH,
    PATTERN_TERMS,
    PATTERN_WIDTH,
    RULES,
    SPEED_TERMS,
    FuzzyExpert,
)


def control_system(expert: FuzzyExpert, points: int = 601) -> object:
    """Return the strategy as a ``skfuzzy.control.ControlSystem``, for plots and tests.

    Inputs ``distance`` [m], ``speed`` [m/s] and ``pattern`` (code), output ``kept``. scikit-fuzzy
    uses the centroid of the output terms instead of eq 9, without R_s and R_max.

    Args:
        expert: The options. Crisp patterns become narrow Gaussians without overlap.
        points: Resolution of each universe.
    """
    try:
        import skfuzzy as fuzz
        from skfuzzy import control
    except ImportError as error:  # a dependency of scikit-fuzzy may be missing
        name = (error.name or "skfuzzy").replace("skfuzzy", "scikit-fuzzy")
        raise MissingExtra(name, "fuzzy") from error
    distance = control.Antecedent(np.linspace(0.0, 4.0, points), "distance")
    speed = control.Antecedent(np.linspace(0.0, 2.0, points), "speed")
    pattern = control.Antecedent(np.linspace(0.0, 3.0, points), "pattern")
    kept = control.Consequent(np.linspace(0.0, 1.0, points), "kept")
    for variable, terms in ((distance, DISTANCE_TERMS), (speed, SPEED_TERMS)):
        for name, (c, s_left, s_right) in terms.items():
            variable[name] = fuzz.gauss2mf(variable.universe, c, s_left, c, s_right)
    width = PATTERN_WIDTH if expert.pattern == "gaussian" else 0.01
    for code, name in enumerate(PATTERN_TERMS):
        pattern[name] = fuzz.gaussmf(pattern.universe, code, width)
    for name, fraction in KEPT_TERMS.items():
        kept[name] = fuzz.gaussmf(kept.universe, fraction, KEPT_WIDTH)
    join = np.multiply if expert.t_norm == "product" else np.fmin
    return control.ControlSystem(
        [
            control.Rule(distance[r] & speed[v] & pattern[b], kept[out], and_func=join)
            for r, v, b, out in RULES[expert.rules]
        ]
    )
