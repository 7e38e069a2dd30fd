"""Fuzzy inference: membership functions and the speed controller (paper section 3.2.3, eq 9).

Terms and rules are arguments, as arrays; the paper's are in ``policies/fuzzy_expert.py``. The
controller averages singletons over rules as in eq 9; Mamdani's centroid, for comparison, cannot
reach standstill (A8, docs/paper.md). The fuzzy-PID wheel loop has its own file,
``core/fuzzy_pid.py``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import kernel, scalar
from hazbot_gym.core.state import Floats

NO_RULE_WEIGHT = 1e-12  # sum of rule weights below which no rule counts as fired
CENTROID_POINTS = 101  # at which the output sets are evaluated


@scalar
def gauss(x: float, c: float, s: float) -> float:
    """Return the membership exp(-(x - c)^2 / (2 s^2)); an infinite width s gives 1 everywhere."""
    z = (x - c) / s
    return math.exp(-0.5 * z * z)


@scalar
def two_sided_gauss(x: float, c: float, s_left: float, s_right: float) -> float:
    """Return a Gaussian membership of two widths; an infinite one is a shoulder of membership 1."""
    return gauss(x, c, s_left if x < c else s_right)


@scalar
def triangle(x: float, c: float, half_width: float) -> float:
    """Return the membership of an isosceles triangle: 1 at c, 0 from c +- half_width on."""
    return max(0.0, 1.0 - abs(x - c) / half_width)


class SpeedRules(NamedTuple):
    """A fuzzy speed controller as arrays, ready for kernels.

    Attributes:
        distance: (D, 3) terms of the distance R_r: centre, width left, width right [m].
        speed: (V, 3) terms of the person's speed V_j, likewise [m/s].
        rules: (J, 4) one rule a row: distance term, speed term, pattern, speed factor 1 - dV_j.
        pattern_width: Width of Gaussian patterns around their codes; 0 = crisp patterns.
        is_product: Whether the t-norm of premises is the product instead of the minimum.
        sensitive_m: R_s, distance up to which the robot stops regardless of rules [m].
        avoidance_m: R_max, distance beyond which people are ignored [m].
        kept_width: Width of Gaussian output sets around the speed factors, with centroid
            defuzzification; 0 = singletons and eq 9.
    """

    distance: Floats
    speed: Floats
    rules: Floats
    pattern_width: float
    is_product: bool
    sensitive_m: float
    avoidance_m: float
    kept_width: float = 0.0


@scalar
def pattern_membership(pattern: int, code: int, width: float) -> float:
    """Return the membership of a pattern in a rule's; no pattern (-1) matches none."""
    if pattern < 0:
        return 0.0
    if width == 0.0:
        return 1.0 if pattern == code else 0.0
    return gauss(pattern, code, width)


@scalar
def rule_weight(m1: float, m2: float, m3: float, is_product: bool) -> float:
    """Return the weight w_j of a rule: the minimum or the product of its premises' memberships."""
    return m1 * m2 * m3 if is_product else min(m1, m2, m3)


@scalar
def weight_in(
    j: int, distance_m: float, speed_mps: float, pattern: int, controller: SpeedRules
) -> float:
    """Return the weight w_j of rule j beside one person; arguments as of ``kept_fraction``."""
    near, fast, rules = controller.distance, controller.speed, controller.rules
    m3 = pattern_membership(pattern, int(rules[j, 2]), controller.pattern_width)
    if m3 == 0.0:  # the rule does not fire, for both t-norms
        return 0.0
    r, v = int(rules[j, 0]), int(rules[j, 1])
    return rule_weight(
        two_sided_gauss(distance_m, near[r, 0], near[r, 1], near[r, 2]),
        two_sided_gauss(speed_mps, fast[v, 0], fast[v, 1], fast[v, 2]),
        m3,
        controller.is_product,
    )


@scalar
def kept_fraction(
    distance_m: float, speed_mps: float, pattern: int, controller: SpeedRules
) -> float:
    """Return the speed factor (share of the nominal speed) for one person (eq 9).

    dV = sum_j w_j dV_j / sum_j w_j, kept = 1 - dV. 1 beyond R_max or if no rule fires, 0 up to R_s.

    Args:
        distance_m: R_r, from centre to centre [m].
        speed_mps: The person's speed V_j [m/s].
        pattern: Code of the person's pattern B_j (``core.state``), or -1.
        controller: Terms and rules.
    """
    if distance_m <= controller.sensitive_m:
        return 0.0
    if distance_m > controller.avoidance_m:
        return 1.0
    if controller.kept_width > 0.0:
        return _centroid(distance_m, speed_mps, pattern, controller)
    sum_w, sum_kept = 0.0, 0.0
    for j in range(controller.rules.shape[0]):
        w = weight_in(j, distance_m, speed_mps, pattern, controller)
        sum_w += w
        sum_kept += w * controller.rules[j, 3]
    return sum_kept / sum_w if sum_w >= NO_RULE_WEIGHT else 1.0


@scalar
def _centroid(distance_m: float, speed_mps: float, pattern: int, controller: SpeedRules) -> float:
    """Return the centroid of the output sets: Mamdani's minimum and maximum, trapezoidal rule.

    kept = int x mu(x) dx / int mu(x) dx,  mu(x) = max_j min(w_j, exp(-(x - kept_j)^2 / (2 s^2)))
    """
    area, moment = 0.0, 0.0
    for i in range(CENTROID_POINTS):
        x, mu = i / (CENTROID_POINTS - 1), 0.0
        for j in range(controller.rules.shape[0]):
            w = weight_in(j, distance_m, speed_mps, pattern, controller)
            mu = max(mu, min(w, gauss(x, controller.rules[j, 3], controller.kept_width)))
        if i in (0, CENTROID_POINTS - 1):
            mu *= 0.5
        area += mu
        moment += mu * x
    return moment / area if area >= NO_RULE_WEIGHT else 1.0


@kernel
def kept_fractions(
    distances: Floats, speeds: Floats, patterns: npt.NDArray[np.int64], controller: SpeedRules
) -> Floats:
    """Return the smallest speed factor of each row of people: (N, K) arrays to (N,).

    An absent person has an infinite distance.
    """
    kept = np.ones(distances.shape[0])
    for i in range(distances.shape[0]):
        for k in range(distances.shape[1]):
            one = kept_fraction(distances[i, k], speeds[i, k], patterns[i, k], controller)
            kept[i] = min(kept[i], one)
    return kept
