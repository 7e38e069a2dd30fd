"""Fuzzy expert, the paper's strategy and reference policy: speed by distance, speed and pattern.

Terms and rules (paper Table 1 and section 3.2.3, completed as in docs/paper.md) are data in this
file. Both the compiled controller and the scikit-fuzzy control system of ``fuzzy_system.py`` use
them. For several people, the slowest speed counts.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from annotated_types import Ge, Gt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.fuzzy import SpeedRules, kept_fraction
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import CROSSING, NO_PATTERN, PATTERN_NAMES, Floats, Ints
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.policies.person_columns import Columns, columns_of
from hazbot_gym.task.observation import layout_of

# --- terms and rules -----------------------------------------------------------------------------

SENSITIVE_M = 1.5  # R_s: the robot stops (paper)
AVOIDANCE_M = 3.0  # R_max: farther people are ignored (paper)
HALF_WIDTH = 2.0 * math.sqrt(2.0 * math.log(2.0))  # spacing / s for neighbours that cross at 0.5
SHOULDER = math.inf  # width of a shoulder, on which the membership stays 1


def _between(low: float, high: float) -> float:
    return (high - low) / HALF_WIDTH


# Centre, width left, width right [m]; centres at 75 and 90 % of R_max (A9, docs/paper.md).
DISTANCE_TERMS = {
    "DS": (1.50, SHOULDER, _between(1.50, 2.25)),
    "DE": (2.25, _between(1.50, 2.25), _between(2.25, 2.70)),
    "DN": (2.70, _between(2.25, 2.70), _between(2.70, 3.00)),
    "DF": (3.00, _between(2.70, 3.00), SHOULDER),
}
# Slow and fast walking [m/s]; the paper's sentence swaps the two (A18, A19).
SPEED_TERMS = {
    "VS": (0.65, SHOULDER, _between(0.65, 1.30)),
    "VF": (1.30, _between(0.65, 1.30), SHOULDER),
}
PATTERN_TERMS = ("BS", "BE", "BL", "BF")  # crossing, encountering, leading, confronting
PATTERN_WIDTH = 1.0 / HALF_WIDTH  # of the optional Gaussian patterns, in codes
KEPT_TERMS = {"VD": 0.00, "VZ": 0.25, "VI": 0.50, "VR": 0.75, "VT": 1.00}  # share of v_nom (A5)
KEPT_WIDTH = 0.25 / HALF_WIDTH  # of their Gaussian sets, for the centroid alone

# The eight printed rules: distance, speed, pattern, speed factor.
LITERAL_8 = """
    DS VS BS VD
    DS VF BS VD
    DE VS BE VI
    DE VF BE VZ
    DN VS BL VR
    DN VF BL VI
    DF VS BF VT
    DF VF BF VT
"""
# Distance, speed, then the speed factor for each of the four patterns.
COMPLETE_32 = """
    DS VS   VD VD VD VD
    DS VF   VD VD VD VD
    DE VS   VI VI VI VZ
    DE VF   VZ VZ VI VD
    DN VS   VR VR VR VI
    DN VF   VI VI VI VZ
    DF VS   VT VT VT VT
    DF VF   VT VT VT VT
"""


def literal_rules() -> list[tuple[str, ...]]:
    """Return the paper's eight rules as (distance, speed, pattern, speed factor)."""
    return [tuple(line.split()) for line in LITERAL_8.strip().splitlines()]


def complete_rules() -> list[tuple[str, ...]]:
    """Return the complete 32 rules, one per combination of terms, in the same format."""
    rows = (line.split() for line in COMPLETE_32.strip().splitlines())
    return [
        (distance, speed, pattern, kept)
        for distance, speed, *outputs in rows
        for pattern, kept in zip(PATTERN_TERMS, outputs, strict=True)
    ]


RULES = {"literal8": literal_rules(), "complete32": complete_rules()}

# --- the policy ----------------------------------------------------------------------------------

PERSON_FIELDS = (
    "present",
    "distance_m",
    "speed_mps",
    "bearing_cos",
    "closing_mps",
    *PATTERN_NAMES,
)


@dataclass(frozen=True, config=OPTIONS)
class FuzzyExpert(PeopleRule):
    """The paper's strategy, on tracked people or on the estimates of ``sonar_estimate``.

    On the sonar tier, people at bearings from 30 to 75 deg are in a blind sector between the front
    and side cones. A robot without memory would forget a passing person and drive on within R_s;
    therefore people are extrapolated for a while after they leave a cone. People who leave a blind
    sector are detected late. People who stay in a blind sector on a collision course are not
    detected at all: in the paper's geometry C90 (scenario ``C90``) the robot drives into the
    person.

    Attributes:
        rules: The 32 rules, with a stop within R_s, or only the 8 printed ones, which do not cover
            all patterns.
        pattern: Crisp patterns, or Gaussian ones over their codes.
        t_norm: T-norm of a rule's premises.
        release: Whether to ignore people behind who recede beyond R_s. Otherwise the speed recovers
            gradually with distance, as in the paper.
        scale: Scale of all distances relative to the paper's; the sweep parameter.
        horizon_s: t of equation 8b, which reduces the distance for a moving robot,
            R_theta = R_r - v t. The paper gives no value, and no reported event needs it (A14,
            docs/paper.md).
    """

    rules: Literal["complete32", "literal8"] = "complete32"
    pattern: Literal["crisp", "gaussian"] = "crisp"
    t_norm: Literal["min", "product"] = "min"
    release: bool = False
    scale: Annotated[float, Gt(0)] = 1.0
    horizon_s: Annotated[float, Ge(0)] = 0.0

    @cached_property
    def controller(self) -> SpeedRules:
        """Terms and rules as arrays for the compiled controller."""
        distances, speeds = list(DISTANCE_TERMS), list(SPEED_TERMS)
        rows = [
            (distances.index(r), speeds.index(v), PATTERN_TERMS.index(b), KEPT_TERMS[kept])
            for r, v, b, kept in RULES[self.rules]
        ]
        return SpeedRules(
            distance=np.array(list(DISTANCE_TERMS.values())),
            speed=np.array(list(SPEED_TERMS.values())),
            rules=np.array(rows, dtype=np.float64),
            pattern_width=PATTERN_WIDTH if self.pattern == "gaussian" else 0.0,
            is_product=self.t_norm == "product",
            sensitive_m=SENSITIVE_M if self.rules == "complete32" else 0.0,
            avoidance_m=AVOIDANCE_M,
        )

    def speed_share(self, observation: Observations) -> npt.ArrayLike:
        """Return the smallest speed factor over all people; see ``base.Rule``."""
        return self._kept(observation, np.float64(self.horizon_s))

    def _kept(self, observation: Observations, horizon_s: npt.ArrayLike) -> Observations:
        """Return the smallest speed factor over all people, with a horizon per observation [s]."""
        rows = np.atleast_2d(np.ascontiguousarray(observation, np.float32))
        kept = np.empty(len(rows), np.float32)
        horizons = np.broadcast_to(np.asarray(horizon_s, np.float64), len(rows)).copy()
        columns = columns_of(layout_of(rows), PERSON_FIELDS)
        answer(rows, columns, self.controller, self.release, self.scale, horizons, kept)
        return kept.reshape(np.shape(observation)[:-1])


@scalar
def _person_counts(
    present: float, bearing_cos: float, closing_mps: float, distance_m: float, release: bool
) -> bool:
    """Return True if a person is present and not released (behind, receding, beyond R_s)."""
    is_leaving = release and bearing_cos < 0.0 and closing_mps < 0.0 and distance_m > SENSITIVE_M
    return present > 0.5 and not is_leaving


@scalar
def _pattern(row: Observations, index: Ints) -> int:
    """Return the pattern of the set flag, or ``NO_PATTERN``."""
    for k in range(index.shape[0]):
        if row[index[k]] > 0.5:
            return CROSSING + k
    return NO_PATTERN


@lean_kernel
def answer(
    rows: Observations,
    columns: Columns,
    controller: SpeedRules,
    release: bool,
    scale: float,
    horizons_s: Floats,
    out: Observations,
) -> None:
    """Write the smallest speed factor over all people for each observation: (N, n) to (N,)."""
    index, units = columns.entries, columns.units
    for i in range(rows.shape[0]):
        kept, row = 1.0, rows[i]
        come_m = row[columns.own[0]] * columns.own_units[0] * horizons_s[i]  # v t of eq 8b
        for k in range(index.shape[0]):
            present = row[index[k, 0]] * units[k, 0]
            away_m = row[index[k, 1]] * units[k, 1] / scale
            speed_mps = row[index[k, 2]] * units[k, 2]
            bearing_cos = row[index[k, 3]] * units[k, 3]
            closing_mps = row[index[k, 4]] * units[k, 4]
            if _person_counts(present, bearing_cos, closing_mps, away_m, release):
                distance_m = away_m - come_m / scale
                pattern = _pattern(row, index[k, 5:])
                kept = min(kept, kept_fraction(distance_m, speed_mps, pattern, controller))
        out[i] = kept
