from __future__ import annotations

import math

import numba
import numpy as np
import pytest
import skfuzzy

from hazbot_gym.core.fuzzy import (
    SpeedRules,
    gauss,
    kept_fraction,
    kept_fractions,
    pattern_membership,
    rule_weight,
    triangle,
    two_sided_gauss,
)

# Two distances (near, far), two speeds (slow, fast), one pattern: stop near, 0.8 or 0.6 far.
RULES = SpeedRules(
    distance=np.array([[1.0, math.inf, 0.5], [2.0, 0.5, math.inf]]),
    speed=np.array([[0.5, math.inf, 0.3], [1.5, 0.3, math.inf]]),
    rules=np.array([[0, 0, 1, 0.0], [0, 1, 1, 0.0], [1, 0, 1, 0.8], [1, 1, 1, 0.6]], dtype=float),
    pattern_width=0.0,
    is_product=False,
    sensitive_m=0.5,
    avoidance_m=3.0,
)


def test_gauss_is_one_at_its_centre_and_a_half_at_half_its_full_width() -> None:
    assert gauss(2.0, 2.0, 0.3) == 1.0
    assert gauss(2.0 + 0.3 * math.sqrt(2.0 * math.log(2.0)), 2.0, 0.3) == pytest.approx(0.5)


def test_two_sides_have_their_own_widths() -> None:
    assert two_sided_gauss(1.0, 2.0, 0.5, 0.1) == pytest.approx(math.exp(-2.0))
    assert two_sided_gauss(2.2, 2.0, 0.5, 0.1) == pytest.approx(math.exp(-2.0))


def test_infinite_width_is_a_shoulder() -> None:
    assert two_sided_gauss(-100.0, 2.0, math.inf, 0.1) == 1.0
    assert two_sided_gauss(100.0, 2.0, 0.1, math.inf) == 1.0


def test_triangle_by_hand() -> None:
    assert [triangle(x, 1.0, 2.0) for x in (-1.0, 0.0, 1.0, 2.5, 9.0)] == [0.0, 0.5, 1.0, 0.25, 0.0]


def test_memberships_are_those_of_scikit_fuzzy() -> None:
    x = np.linspace(-3.0, 3.0, 61)
    ours = np.array([[gauss(v, 0.4, 0.7), triangle(v, 0.4, 0.7)] for v in x])

    assert ours[:, 0] == pytest.approx(skfuzzy.gaussmf(x, 0.4, 0.7), abs=1e-12)
    assert ours[:, 1] == pytest.approx(skfuzzy.trimf(x, [-0.3, 0.4, 1.1]), abs=1e-12)


def test_crisp_patterns_match_exactly_and_gaussian_ones_bleed() -> None:
    assert pattern_membership(1, 1, 0.0) == 1.0
    assert pattern_membership(2, 1, 0.0) == 0.0
    assert pattern_membership(2, 1, 0.4247) == pytest.approx(math.exp(-0.5 / 0.4247**2))


@pytest.mark.parametrize("width", [0.0, 0.4247])
def test_person_without_a_pattern_matches_no_rule(width: float) -> None:
    assert pattern_membership(-1, 0, width) == 0.0


def test_premises_join_by_minimum_or_product() -> None:
    assert rule_weight(0.5, 0.8, 1.0, False) == 0.5
    assert rule_weight(0.5, 0.8, 1.0, True) == pytest.approx(0.4)


def test_weighted_average_by_hand() -> None:
    near = math.exp(-0.5 * (0.7 / 0.5) ** 2)
    far = math.exp(-0.5 * (0.3 / 0.5) ** 2)
    fast = math.exp(-0.5 * (0.9 / 0.3) ** 2)  # at 0.6 m/s: slow is exp(-1/18)
    slow = math.exp(-0.5 * (0.1 / 0.3) ** 2)
    weights = [min(near, slow), min(near, fast), min(far, slow), min(far, fast)]
    expected = (0.8 * weights[2] + 0.6 * weights[3]) / sum(weights)

    assert kept_fraction(1.7, 0.6, 1, RULES) == pytest.approx(expected)


def test_centroid_of_a_single_set_lies_at_its_middle_and_never_at_the_end() -> None:
    rules = RULES._replace(kept_width=0.1062, rules=np.array([[1, 0, 1, 0.5]]))
    assert kept_fraction(1.9, 0.4, 1, rules) == pytest.approx(0.5)
    stop = rules._replace(rules=np.array([[1, 0, 1, 0.0]]))
    # The half of a Gaussian of width s beside its centre has its centroid at s sqrt(2 / pi).
    assert kept_fraction(2.5, 0.4, 1, stop) == pytest.approx(0.1062 * math.sqrt(2 / math.pi), 1e-3)


def test_robot_stands_up_to_the_sensitive_distance_and_ignores_people_beyond_the_other() -> None:
    assert kept_fraction(0.5, 0.5, 1, RULES) == 0.0
    assert kept_fraction(0.501, 0.5, 1, RULES) > 0.0
    assert kept_fraction(3.0, 0.5, 1, RULES) < 1.0
    assert kept_fraction(3.001, 0.5, 1, RULES) == 1.0


def test_nothing_is_reduced_when_no_rule_fires() -> None:
    assert kept_fraction(1.7, 0.6, 0, RULES) == 1.0
    assert kept_fraction(0.5, 0.6, 0, RULES) == 0.0


def test_slowest_answer_to_any_person_counts() -> None:
    distances = np.array([[1.7, 2.0, np.inf], [np.inf, np.inf, np.inf]])
    patterns = np.ones((2, 3), dtype=np.int64)

    kept = kept_fractions(distances, np.full((2, 3), 0.6), patterns, RULES)

    assert kept == pytest.approx([kept_fraction(1.7, 0.6, 1, RULES), 1.0])


def test_compiled_controller_is_that_of_plain_python() -> None:
    rng = np.random.default_rng(2)
    distances, speeds = rng.uniform(0.4, 3.2, (300, 1)), rng.uniform(0.0, 2.0, (300, 1))
    patterns = rng.integers(-1, 4, (300, 1))
    changes = ({}, {"is_product": True}, {"pattern_width": 0.4247}, {"kept_width": 0.1062})
    for rules in (RULES._replace(**change) for change in changes):
        plain = [
            kept_fraction(float(d), float(v), int(b), rules)
            for d, v, b in zip(distances[:, 0], speeds[:, 0], patterns[:, 0], strict=True)
        ]
        assert kept_fractions(distances, speeds, patterns, rules) == pytest.approx(plain, abs=1e-14)


def test_formulas_compile_on_their_own() -> None:
    @numba.njit
    def compiled(x: float) -> float:
        return two_sided_gauss(x, 1.0, np.inf, 0.5) + triangle(x, 1.0, 0.5)

    assert compiled(1.2) == pytest.approx(two_sided_gauss(1.2, 1.0, math.inf, 0.5) + 0.6)
