"""The combination (paper section 5.2, Figure 19): a human enters while the robot tracks the circle.

"It detected that a pedestrian had entered the avoidance distance, assessed as the encountering
pattern, and decelerated on the predetermined trajectory. As the pedestrian gradually moved away,
the robot gradually returned to its initial speed and continued to follow the target trajectory."
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.paper.sections.meetings.experiment import Events, Meeting, events, meet

SCENARIO = "circle+human"
WITHOUT_HUMAN = {"people": {"walkers": [{"x_m": 90.0, "y_m": 90.0, "vx_mps": 0.0, "vy_mps": 0.0}]}}
STEPS = 800


class Combination(NamedTuple):
    """The circle with and without the human, over the same noise seeds."""

    runs: list[Meeting]
    alone: list[Meeting]
    found: list[Events]

    def tracking_rms_m(self) -> tuple[float, float]:
        """Return the RMS position error with and without the human [m]."""
        return _rms(self.runs), _rms(self.alone)

    def largest_m(self, from_s: float = 0.0) -> tuple[float, float]:
        """Return the largest position error after a time, with and without the human [m]."""
        return _largest(self.runs, from_s), _largest(self.alone, from_s)

    def final_m(self, last_s: float) -> tuple[float, float]:
        """Return the largest final position error, with and without the human [m]."""
        return _final(self.runs, last_s), _final(self.alone, last_s)

    def arrivals(self) -> float:
        """Return the share of laps with the human that were driven to their end."""
        return float(np.mean([len(run.time_s) < STEPS for run in self.runs]))

    def lap_s(self) -> tuple[float, float]:
        """Return the mean time of the lap with and without the human [s]."""
        return _duration(self.runs), _duration(self.alone)


def combine(seeds: int) -> Combination:
    """Drive the circle with the fuzzy strategy, with and without the human."""
    runs = meet(SCENARIO, seeds=range(seeds), steps=STEPS)
    alone = meet(SCENARIO, seeds=range(seeds), steps=STEPS, overrides=WITHOUT_HUMAN)
    return Combination(runs, alone, [events(run, is_measured=True) for run in runs])


def _errors(runs: list[Meeting]) -> Floats:
    return np.concatenate([run.position_error_m for run in runs])


def _rms(runs: list[Meeting]) -> float:
    return float(np.sqrt(np.mean(_errors(runs) ** 2)))


def _largest(runs: list[Meeting], from_s: float) -> float:
    return max(float(run.position_error_m[run.time_s >= from_s].max()) for run in runs)


def _final(runs: list[Meeting], last_s: float) -> float:
    return max(_largest([run], float(run.time_s[-1]) - last_s) for run in runs)


def _duration(runs: list[Meeting]) -> float:
    return float(np.mean([run.time_s[-1] for run in runs]))
