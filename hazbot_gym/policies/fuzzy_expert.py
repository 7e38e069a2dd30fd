"""The paper's fuzzy strategy, the reference policy: who is how near, how fast, and walking how?

Terms and rules (paper Table 1 and section 3.2.3, completed in SPEC section 3) are stated here once,
as data. From them come the compiled controller that runs and the scikit-fuzzy control system for
plots and tests. Near several people the slowest answer counts.
"""

from __future__ import annotations

import math
from functools import cache, cached_property
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from annotated_types import Gt
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from hazbot_gym.core.fuzzy import SpeedRules, kept_fraction
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import CROSSING, NO_PATTERN, PATTERN_NAMES, Floats, Ints
from hazbot_gym.errors import MissingExtra
from hazbot_gym.policies.base import Observations
from hazbot_gym.policies.people_rule import PeopleRule
from hazbot_gym.task.observation import PERSON_SLOTS, layout_of

# --- terms and rules -----------------------------------------------------------------------------

SENSITIVE_M = 1.5  # R_s: the robot stands (paper)
AVOIDANCE_M = 3.0  # R_max: people beyond are ignored (paper)
HALF_WIDTH = 2.0 * math.sqrt(2.0 * math.log(2.0))  # spacing / s for neighbours that cross at 0.5
SHOULDER = math.inf  # the width of a side on which the membership stays 1


def _between(low: float, high: float) -> float:
    return (high - low) / HALF_WIDTH


# Centre, width left, width right [m]; centres at 75 and 90 % of R_max (SPEC A9).
DISTANCE_TERMS = {
    "DS": (1.50, SHOULDER, _between(1.50, 2.25)),
    "DE": (2.25, _between(1.50, 2.25), _between(2.25, 2.70)),
    "DN": (2.70, _between(2.25, 2.70), _between(2.70, 3.00)),
    "DF": (3.00, _between(2.70, 3.00), SHOULDER),
}
# Slow and fast walking [m/s]; the paper's sentence swaps the two (SPEC A18, A19).
SPEED_TERMS = {
    "VS": (0.65, SHOULDER, _between(0.65, 1.30)),
    "VF": (1.30, _between(0.65, 1.30), SHOULDER),
}
PATTERN_TERMS = ("BS", "BE", "BL", "BF")  # crossing, encountering, leading, confronting
PATTERN_WIDTH = 1.0 / HALF_WIDTH  # of the optional Gaussian patterns, in codes
KEPT_TERMS = {"VD": 0.00, "VZ": 0.25, "VI": 0.50, "VR": 0.75, "VT": 1.00}  # share of v_nom (A5)

# The eight printed rules: distance, speed, pattern, kept speed.
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
# Distance, speed, then the kept speed for each of the four patterns (SPEC 3.3).
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
    """Return the paper's eight rules as (distance, speed, pattern, kept speed)."""
    return [tuple(line.split()) for line in LITERAL_8.strip().splitlines()]


def complete_rules() -> list[tuple[str, ...]]:
    """Return the 32 rules, one for every combination of terms, likewise."""
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


class Columns(NamedTuple):
    """Where an observation holds what the strategy reads of each person."""

    index: Ints  # (K, fields)
    units: Floats  # (K, fields) factors to physical units


@cache
def _columns(width: int) -> Columns:
    layout = layout_of(np.empty(width))
    slots = range(PERSON_SLOTS)
    index = [[layout.names.index(f"person{i}_{name}") for name in PERSON_FIELDS] for i in slots]
    units = [[layout.fields[column].scale for column in row] for row in index]
    return Columns(np.array(index), np.array(units))


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FuzzyExpert(PeopleRule):
    """The paper's strategy, on tracked people or on those of ``sonar_estimate``.

    On the sonar tier it cannot see who is between the cones in front and those at the sides, at
    bearings from 30 to 75 deg. SPEC section 4.2 found a robot that so forgets a passing person and
    drives on within R_s; here people are carried on for a while when they leave a cone. Who comes
    out of a blind sector is seen late, and who stays in one on a collision course is not seen at
    all: in the paper's geometry C90 (scenario ``C90``) the robot drives into the person.

    Attributes:
        rules: The 32 rules, with a stop within R_s, or the 8 printed ones and nothing else: these
            leave whole patterns without an answer.
        pattern: Whether patterns are crisp or Gaussian on their codes.
        t_norm: How a rule's premises are joined.
        release: Whether somebody behind and receding beyond R_s counts as nobody. Without it the
            speed recovers with distance, gradually as in the paper.
        scale: Distances at which it answers, in multiples of the paper's; the knob of the family.
    """

    rules: Literal["complete32", "literal8"] = "complete32"
    pattern: Literal["crisp", "gaussian"] = "crisp"
    t_norm: Literal["min", "product"] = "min"
    release: bool = False
    scale: Annotated[float, Gt(0)] = 1.0

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

    def speed_share(self, observation: Observations) -> Observations:
        """Return the slowest answer to any person; see ``base.Rule``."""
        rows = np.atleast_2d(np.ascontiguousarray(observation, np.float32))
        kept = np.empty(len(rows), np.float32)
        _answer(rows, _columns(rows.shape[1]), self.controller, self.release, self.scale, kept)
        return kept.reshape(np.shape(observation)[:-1])


@scalar
def _person_counts(
    present: float, bearing_cos: float, closing_mps: float, distance_m: float, release: bool
) -> bool:
    """Return whether a person is there, and not let go as behind and receding beyond R_s."""
    is_leaving = release and bearing_cos < 0.0 and closing_mps < 0.0 and distance_m > SENSITIVE_M
    return present > 0.5 and not is_leaving


@scalar
def _pattern(row: Observations, index: Ints) -> int:
    """Return the pattern whose flag is raised, or ``NO_PATTERN``."""
    for k in range(index.shape[0]):
        if row[index[k]] > 0.5:
            return CROSSING + k
    return NO_PATTERN


@lean_kernel
def _answer(
    rows: Observations,
    columns: Columns,
    controller: SpeedRules,
    release: bool,
    scale: float,
    out: Observations,
) -> None:
    """Write the smallest kept fraction beside any person for each observation: (N, n) to (N,)."""
    index, units = columns.index, columns.units
    for i in range(rows.shape[0]):
        kept, row = 1.0, rows[i]
        for k in range(index.shape[0]):
            present = row[index[k, 0]] * units[k, 0]
            distance_m = row[index[k, 1]] * units[k, 1] / scale
            speed_mps = row[index[k, 2]] * units[k, 2]
            bearing_cos = row[index[k, 3]] * units[k, 3]
            closing_mps = row[index[k, 4]] * units[k, 4]
            if _person_counts(present, bearing_cos, closing_mps, distance_m, release):
                pattern = _pattern(row, index[k, 5:])
                kept = min(kept, kept_fraction(distance_m, speed_mps, pattern, controller))
        out[i] = kept


# --- the same system in scikit-fuzzy -------------------------------------------------------------


def control_system(expert: FuzzyExpert, points: int = 601) -> Any:
    """Return the strategy as a ``skfuzzy.control.ControlSystem``, for plots and tests.

    Inputs ``distance`` [m], ``speed`` [m/s] and ``pattern`` (code), output ``kept``. scikit-fuzzy
    takes the centroid of the output terms instead of eq 9, and knows neither R_s nor R_max.

    Args:
        expert: The options. Crisp patterns become Gaussian ones too narrow to reach another code.
        points: Resolution of each universe.
    """
    try:
        import skfuzzy as fuzz
        from skfuzzy import control
    except ImportError:
        raise MissingExtra("scikit-fuzzy", "fuzzy") from None
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
        kept[name] = fuzz.gaussmf(kept.universe, fraction, 0.25 / HALF_WIDTH)
    join = np.multiply if expert.t_norm == "product" else np.fmin
    return control.ControlSystem(
        [
            control.Rule(distance[r] & speed[v] & pattern[b], kept[out], and_func=join)
            for r, v, b, out in RULES[expert.rules]
        ]
    )
