"""Alternative readings of the paper's fuzzy strategy, each with one change (docs/paper.md).

The paper is ambiguous about its eight rules, percentages, weighted mean and speed v(t).
``FuzzyExpert`` is the reading that works; the others are for comparison.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from pydantic.dataclasses import dataclass

from hazbot_gym.core.fuzzy import SpeedRules
from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import OPTIONS
from hazbot_gym.policies.fuzzy_expert import (
    AVOIDANCE_M,
    HALF_WIDTH,
    KEPT_WIDTH,
    PATTERN_WIDTH,
    SENSITIVE_M,
    FuzzyExpert,
)
from hazbot_gym.policies.guard import Actions, Flags, Observations
from hazbot_gym.policies.robot import DECISION_S, NOMINAL_MPS
from hazbot_gym.task.action import speed_action
from hazbot_gym.task.observation import layout_of

Reading = Literal[
    "inverted",  # percentages are reductions instead of speed factors (A5)
    "gaussian",  # patterns have Gaussian memberships, without a stop within R_s (A7)
    "centroid",  # Mamdani centroid instead of the weighted mean of eq 9, without that stop (A8)
    "recursive",  # v(t) is the present speed instead of the nominal one (A6)
    "no_gate",  # no limit at 3.0 m, and DF without its shoulder
    "horizon",  # eq 8b with t = 1 s (A14)
    "elapsed",  # eq 8b with t = the time since the start (A14)
    "span",  # 75 and 90 % of the way from 1.5 to 3.0 m (A9)
    "width",  # all terms of the distance 0.25 m wide, for any spacing
    "split",  # slow and fast divided at 0.5 instead of 0.975 m/s (A19)
]
READINGS: tuple[str, ...] = get_args(Reading)
COMMON_WIDTH_M = 0.25  # of the reading "width": nearest to the paper's times


def _widths(centres: Floats) -> Floats:
    """Return terms (c, width left, width right) whose neighbours cross at 0.5, with shoulders."""
    gaps = np.diff(centres) / HALF_WIDTH
    return np.stack([centres, [math.inf, *gaps], [*gaps, math.inf]], axis=1)


@dataclass(frozen=True, config=OPTIONS)
class FuzzyReading(FuzzyExpert):
    """The strategy with one alternative reading; for tracked people."""

    reading: Reading = "inverted"

    @cached_property
    def controller(self) -> SpeedRules:
        """Terms and rules of the reading as arrays."""
        chosen = super().controller
        if self.reading == "inverted":
            rules = chosen.rules.copy()
            rules[:, 3] = 1.0 - rules[:, 3]
            return chosen._replace(rules=rules, sensitive_m=0.0)
        if self.reading == "gaussian":
            return chosen._replace(pattern_width=PATTERN_WIDTH, sensitive_m=0.0)
        if self.reading == "centroid":
            return chosen._replace(kept_width=KEPT_WIDTH, sensitive_m=0.0)
        if self.reading == "no_gate":
            distance = chosen.distance.copy()
            distance[-1, 2] = distance[-1, 1]
            return chosen._replace(distance=distance, avoidance_m=math.inf)
        if self.reading == "span":
            span = AVOIDANCE_M - SENSITIVE_M
            centres = SENSITIVE_M + span * np.array([0.0, 0.75, 0.9, 1.0])
            return chosen._replace(distance=_widths(centres))
        if self.reading == "width":
            distance = chosen.distance.copy()
            distance[:, 1:][np.isfinite(distance[:, 1:])] = COMMON_WIDTH_M
            return chosen._replace(distance=distance)
        if self.reading == "split":
            return chosen._replace(speed=_widths(np.array([1.0, 2.0]) / 3.0))
        return chosen

    @property
    def nominal_mps(self) -> float | None:
        """Nominal speed of the only robot that the reading is for; None for any robot."""
        return NOMINAL_MPS if self.reading == "recursive" else None

    def speed_share(self, observation: Observations) -> npt.ArrayLike:
        """Return the speed share of the reading; see ``base.Rule``."""
        kept = self._kept(observation, 1.0 if self.reading == "horizon" else self.horizon_s)
        if self.reading == "recursive":
            command = layout_of(observation).decode(observation)["command_mps"]
            return kept * command / NOMINAL_MPS
        return kept

    def act(
        self, observation: Observations, state: object, starts: Flags | None, deterministic: bool
    ) -> tuple[Actions, object]:
        """Return the action; the state of ``elapsed`` is the time since the start (N,) [s].

        Raises:
            InvalidInput: ``elapsed`` on the sonar tier, whose echoes already use the state.
        """
        if self.reading != "elapsed":
            return super().act(observation, state, starts, deterministic)
        if not layout_of(observation).has_people:
            raise InvalidInput("reading: 'elapsed' is for tracked people, given the tier 'sonar'")
        time_s = np.zeros(np.shape(observation)[:-1]) if state is None else np.asarray(state)
        if starts is not None:
            time_s = np.where(np.reshape(starts, time_s.shape), 0.0, time_s)
        return speed_action(self._kept(observation, time_s)), time_s + DECISION_S
