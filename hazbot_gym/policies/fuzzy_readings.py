"""Other readings of the paper's fuzzy strategy, each with one thing read differently (SPEC 4.2).

The paper leaves open how its eight rules, its percentages, its mean and its speed v(t) are to be
understood. ``FuzzyExpert`` is the reading that works; these are here to be run beside it.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from hazbot_gym.core.fuzzy import SpeedRules, gauss, pattern_membership, two_sided_gauss
from hazbot_gym.core.state import NO_PATTERN, PATTERN_NAMES, Floats
from hazbot_gym.policies.base import Actions, Observations, speed_action
from hazbot_gym.policies.fuzzy_expert import (
    AVOIDANCE_M,
    HALF_WIDTH,
    PATTERN_WIDTH,
    SENSITIVE_M,
    FuzzyExpert,
)
from hazbot_gym.task.observation import PERSON_SLOTS, layout_of

NOMINAL_MPS, DECISION_S = 0.5, 0.1  # the paper's
OUTPUT_WIDTH = 0.25 / HALF_WIDTH  # of the output sets of the centroid (SPEC 3.1)
POINTS = 101  # of its universe

Reading = Literal[
    "inverted",  # percentages are what is taken away instead of kept (A5)
    "gaussian",  # patterns have Gaussian memberships, without a stop within R_s (A7)
    "centroid",  # Mamdani centroid instead of the weighted mean of eq 9 (A8)
    "recursive",  # v(t) is the present speed instead of the nominal one (A6)
    "no_gate",  # no limit at 3.0 m, and DF without its shoulder
    "horizon",  # eq 8b with t = 1 s (A14)
    "elapsed",  # eq 8b with t = the time since the start (A14)
    "span",  # 75 and 90 % of the way from 1.5 to 3.0 m (A9)
    "split",  # slow and fast divided at 0.5 instead of 0.975 m/s (A19)
]
READINGS: tuple[str, ...] = get_args(Reading)


def _widths(centres: Floats) -> Floats:
    """Return terms (c, width left, width right) whose neighbours cross at 0.5, with shoulders."""
    gaps = np.diff(centres) / HALF_WIDTH
    return np.stack([centres, [math.inf, *gaps], [*gaps, math.inf]], axis=1)


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class FuzzyReading(FuzzyExpert):
    """The strategy with one thing read differently; runs on tracked people."""

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
        if self.reading == "no_gate":
            distance = chosen.distance.copy()
            distance[-1, 2] = distance[-1, 1]
            return chosen._replace(distance=distance, avoidance_m=math.inf)
        if self.reading == "span":
            span = AVOIDANCE_M - SENSITIVE_M
            centres = SENSITIVE_M + span * np.array([0.0, 0.75, 0.9, 1.0])
            return chosen._replace(distance=_widths(centres))
        if self.reading == "split":
            return chosen._replace(speed=_widths(np.array([1.0, 2.0]) / 3.0))
        return chosen

    def speed_share(self, observation: Observations) -> npt.ArrayLike:
        """Return the answer of the reading; see ``base.Rule``."""
        if self.reading == "centroid":
            return self._by_centroid(observation)
        kept = self._kept(observation, 1.0 if self.reading == "horizon" else self.horizon_s)
        if self.reading == "recursive":
            command = layout_of(observation).decode(observation)["command_mps"]
            return kept * command / NOMINAL_MPS
        return kept

    def predict(
        self,
        observation: Observations,
        state: Any = None,
        episode_start: npt.NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Actions, Any]:
        """Return the action; the state of ``elapsed`` is the time since the start (N,) [s]."""
        if self.reading != "elapsed":
            return super().predict(observation, state, episode_start, deterministic)
        time_s = np.zeros(np.shape(observation)[:-1]) if state is None else np.asarray(state)
        if episode_start is not None:
            time_s = np.where(np.reshape(episode_start, time_s.shape), 0.0, time_s)
        return speed_action(self._kept(observation, time_s)), time_s + DECISION_S

    def _by_centroid(self, observation: Observations) -> Floats:
        """Return the smallest centroid beside any person."""
        seen = layout_of(observation).decode(np.atleast_2d(observation))
        kept = np.ones(len(np.atleast_2d(observation)))
        for i in range(PERSON_SLOTS):
            flags = np.stack([seen[f"person{i}_{name}"] > 0.5 for name in PATTERN_NAMES])
            pattern = np.where(flags.any(axis=0), flags.argmax(axis=0), NO_PATTERN)
            distance, speed = seen[f"person{i}_distance_m"], seen[f"person{i}_speed_mps"]
            for k in np.flatnonzero(seen[f"person{i}_present"] > 0.5):
                one = centroid(distance[k], speed[k], int(pattern[k]), self.controller)
                kept[k] = min(kept[k], one)
        return kept.reshape(np.shape(observation)[:-1])


def centroid(
    distance_m: float, speed_mps: float, pattern: int, controller: SpeedRules, points: int = POINTS
) -> float:
    """Return the kept fraction by Mamdani's inference: minimum, maximum, centroid of Gaussian sets.

    It cannot reach 0, since the centroid of a set around 0 lies above 0. Arguments as for
    ``core.fuzzy.kept_fraction``.
    """
    if distance_m > controller.avoidance_m:
        return 1.0
    universe = np.linspace(0.0, 1.0, points)
    membership = np.zeros(points)
    for r, v, code, kept in controller.rules:
        weight = min(
            two_sided_gauss(float(distance_m), *controller.distance[int(r)].tolist()),
            two_sided_gauss(float(speed_mps), *controller.speed[int(v)].tolist()),
            pattern_membership(pattern, int(code), controller.pattern_width),
        )
        shape = np.array([gauss(float(x), float(kept), OUTPUT_WIDTH) for x in universe])
        membership = np.maximum(membership, np.minimum(weight, shape))
    total = membership.sum()
    return float(membership @ universe / total) if total > 0.0 else 1.0
