"""Fuzzy-PID: Mamdani inference of the three gains of a wheel loop (paper eq 15).

The paper mentions 49 rules and prints none. This module uses the usual textbook tables (Liu Jinkun,
Advanced PID Control); they help only for the error as actual minus reference, the paper's
convention of eq 10, hence sign -1 (A10, docs/paper.md). The running loop reads a bilinear table of
the inference, within 0.03 of it on outputs of +-3.
"""

from __future__ import annotations

import functools
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt
from annotated_types import Ge

from hazbot_gym.core.fuzzy import gauss, triangle
from hazbot_gym.core.geometry import clip
from hazbot_gym.core.jit import kernel, scalar
from hazbot_gym.core.pid import PidGains
from hazbot_gym.core.state import Floats

LIMIT = 3.0  # inputs and outputs live on [-3, 3] (paper)
WIDTH = 0.4247  # of the Gaussian input terms, centres -3..3: neighbours cross at 0.5
POINTS = 101  # of the discretised output (MATLAB's default)
GRID = 121  # of the bilinear table, each way

TERMS = ("NB", "NM", "NS", "ZO", "PS", "PM", "PB")
TABLES = ("textbook", "symmetric")
# Rows: error, NB to PB; columns: its rate, NB to PB (Liu Jinkun, Advanced PID Control).
_KP_RULES = """
    PB PB PM PM PS ZO ZO
    PB PB PM PS PS ZO NS
    PM PM PM PS ZO NS NS
    PM PM PS ZO NS NM NM
    PS PS ZO NS NS NM NM
    PS ZO NS NM NM NM NB
    ZO ZO NM NM NM NB NB
"""
_KI_RULES = """
    NB NB NM NM NS ZO ZO
    NB NB NM NS NS ZO ZO
    NB NM NS NS ZO PS PS
    NM NM NS ZO PS PM PM
    NM NS ZO PS PS PM PB
    ZO ZO PS PS PM PB PB
    ZO ZO PS PM PM PB PB
"""
_KD_RULES = """
    PS NS NB NB NB NM PS
    PS NS NB NM NM NS ZO
    ZO NS NM NM NS NS ZO
    ZO NS NS NS NS NS ZO
    ZO ZO ZO ZO ZO ZO ZO
    PB NS PS PS PS PS PB
    PB PM PM PM PS PS PB
"""


class FuzzyPid(NamedTuple):
    """Scales of the fuzzy-PID (paper section 3.3)."""

    error_scale: Annotated[float, Ge(0)] = 0.9  # k_e, of the error [s/rad]
    rate_scale: Annotated[float, Ge(0)] = 0.1  # k_ec, of its derivative [s^2/rad]
    kp_span: Annotated[float, Ge(0)] = 3.0  # k_1, of the three outputs
    ki_span: Annotated[float, Ge(0)] = 1.0  # k_2
    kd_span: Annotated[float, Ge(0)] = 1.0  # k_3
    sign: float = -1.0  # s: -1: rules see actual minus reference, +1: the reverse (A10)


def rule_tables(tables: str = "textbook") -> npt.NDArray[np.int64]:
    """Return the output terms of kp, ki, kd as codes -3..3, shape (3, 7, 7): error by rate.

    ``"symmetric"`` mirrors the half of negative errors to positive ones; the textbook's rules raise
    kp for negative errors only.
    """
    rows = [block.split() for block in (_KP_RULES, _KI_RULES, _KD_RULES)]
    codes = np.array([[TERMS.index(term) - 3 for term in row] for row in rows]).reshape(3, 49)
    if tables == "symmetric":
        codes = np.where(np.arange(49) > 24, codes[:, ::-1], codes)
    return codes.reshape(3, 7, 7)


@scalar
def infer(e: float, ec: float, rules: npt.NDArray[np.int64]) -> tuple[float, float, float]:
    """Return the three outputs Fp, Fi, Fd of the Mamdani inference at E = e, EC = ec, each in +-3.

    And, implication: minimum; or, aggregation: maximum; centroid on 101 points with trapezoid
    weights, which come within 0.004 of the exact centroid (a plain sum: 0.048).
    """
    strength = np.zeros((3, 7))
    for i in range(7):
        for j in range(7):
            weight = min(gauss(e, i - 3.0, WIDTH), gauss(ec, j - 3.0, WIDTH))
            for output in range(3):
                term = rules[output, i, j] + 3
                strength[output, term] = max(strength[output, term], weight)
    return centroid(strength[0]), centroid(strength[1]), centroid(strength[2])


@scalar
def centroid(strength: Floats) -> float:
    """Return the centroid of the output terms, triangles at -3..3, cut at their strengths (7,)."""
    area, moment = 0.0, 0.0
    for point in range(POINTS):
        x = LIMIT * (2.0 * point / (POINTS - 1) - 1.0)
        membership = 0.0
        for term in range(7):
            membership = max(membership, min(strength[term], triangle(x, term - 3.0, 1.0)))
        weight = 0.5 if point == 0 or point == POINTS - 1 else 1.0
        area += weight * membership
        moment += weight * membership * x
    return moment / area if area > 0.0 else 0.0


@kernel
def _tabulate(rules: npt.NDArray[np.int64]) -> Floats:
    table = np.empty((GRID, GRID, 3))
    for i in range(GRID):
        for j in range(GRID):
            e = LIMIT * (2.0 * i / (GRID - 1) - 1.0)
            ec = LIMIT * (2.0 * j / (GRID - 1) - 1.0)
            table[i, j, 0], table[i, j, 1], table[i, j, 2] = infer(e, ec, rules)
    return table


@functools.cache  # shared by all environments, as it takes long
def gain_table(tables: str = "textbook") -> Floats:
    """Return the inference on a grid over [-3, 3]^2: (121, 121, 3), error by rate by output."""
    return _tabulate(rule_tables(tables))


@scalar
def look_up(e: float, ec: float, table: Floats) -> tuple[float, float, float]:
    """Return Fp, Fi, Fd from a gain table, bilinear, inputs held to [-3, 3]."""
    steps = 0.5 * (table.shape[0] - 1)
    u = (clip(e / LIMIT, -1.0, 1.0) + 1.0) * steps
    w = (clip(ec / LIMIT, -1.0, 1.0) + 1.0) * steps
    # Clipped from below, too: a loop that diverged to NaN must not index outside the table.
    i = max(0, min(int(u), table.shape[0] - 2))
    j = max(0, min(int(w), table.shape[1] - 2))
    u, w = u - i, w - j
    c00, c01, c10, c11 = (1.0 - u) * (1.0 - w), (1.0 - u) * w, u * (1.0 - w), u * w
    a, b, c, d = table[i, j], table[i, j + 1], table[i + 1, j], table[i + 1, j + 1]
    return (
        c00 * a[0] + c01 * b[0] + c10 * c[0] + c11 * d[0],
        c00 * a[1] + c01 * b[1] + c10 * c[1] + c11 * d[1],
        c00 * a[2] + c01 * b[2] + c10 * c[2] + c11 * d[2],
    )


@scalar
def fuzzy_pid_gains(
    error: float, derivative: float, base: PidGains, fuzzy: FuzzyPid, table: Floats
) -> PidGains:
    """Return the gains of a wheel loop for its present error, none of them negative (eq 15).

    kp = kp' + k_1 Fp(E, EC), ki = ki' + k_2 Fi(E, EC), kd = kd' + k_3 Fd(E, EC), with
    E = s k_e e and EC = s k_ec de/dt, held to [-3, 3].

    Args:
        error: Control error e, reference minus actual [rad/s].
        derivative: Its filtered derivative [rad/s^2].
        base: The initial gains kp', ki', kd'.
        fuzzy: Scales and sign.
        table: From ``gain_table``.
    """
    fp, fi, fd = look_up(
        fuzzy.sign * fuzzy.error_scale * error, fuzzy.sign * fuzzy.rate_scale * derivative, table
    )
    return PidGains(
        max(base.kp + fuzzy.kp_span * fp, 0.0),
        max(base.ki + fuzzy.ki_span * fi, 0.0),
        max(base.kd + fuzzy.kd_span * fd, 0.0),
    )
