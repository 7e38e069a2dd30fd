"""Robustness of the strategy to command delays (paper section 5.1.2).

"The small-scale time delay of the speed change does not affect obstacle avoidance." Here the
strategy's commands are delayed. Criterion, stated beforehand: avoidance is affected once the robot
moves within 1.5 m of the human for 0.1 s longer than without delay.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.paper.sections.meetings.experiment import events, meet
from hazbot_gym.policies.robot import DECISION_S
from hazbot_gym.utils.json_object import JsonObject

SCENARIOS = ("E*", "C*")
EXTRA_S = 0.1  # additional time of motion within 1.5 m
STEPS = (0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30)  # decisions of delay
FAMILIES = ("Crossing", "Encountering")
FAMILY_STEPS = (0, 5, 10, 20)
FAMILY_METRICS = {  # and their names in tables
    "contacts_per_km": "contacts by the robot [1/km]",
    "personal_m": "driven in the personal zone [m]",
    "return": "return",
}
# The realistic drive, with the noise of Table 2.
EARNEST: dict[str, dict[str, object]] = {
    "drive": {"wheel_loop": "fuzzy_pid", "plant": "B"},
    "sensors": {"tracker": {"position_noise_m": 0.03}},
}


class Delayed(NamedTuple):
    """A scenario under growing delays; arrays over delays."""

    delay_s: Floats
    inside_s: Floats  # mean time of moving within 1.5 m
    hits: Floats  # share of seeds in which the moving robot touched the human
    affected_from_s: float  # the smallest delay with an effect, NaN if none


def sweep(scenario: str, *, seeds: int, steps: Sequence[int] = STEPS) -> Delayed:
    """Run a scenario under growing delays."""
    rows = []
    for delay in steps:
        drive = {**EARNEST["drive"], "latency_steps": delay}
        runs = meet(scenario, seeds=range(seeds), overrides={**EARNEST, "drive": drive})
        found = [events(run) for run in runs]
        rows.append([np.mean([each.moving_inside_s for each in found]),
                     np.mean([each.hits for each in found])])  # fmt: skip
    inside_s, hits = np.array(rows).T
    delay_s = DECISION_S * np.array(steps, dtype=np.float64)
    worse = np.flatnonzero(inside_s > inside_s[0] + EXTRA_S)
    first_s = float(delay_s[worse[0]]) if len(worse) else np.nan
    return Delayed(delay_s, inside_s, hits, first_s)


def costliest(rows: Sequence[JsonObject]) -> tuple[JsonObject, JsonObject]:
    """Return the row most in the personal zone, and its family's without a delay."""
    worst = max(rows, key=lambda row: row["personal_m"])
    same = [row for row in rows if row["family"] == worst["family"]]
    return worst, min(same, key=lambda row: row["delay_s"])


def families(episodes: int) -> list[JsonObject]:
    """Return the effect of delays with randomly drawn reactive people."""
    rows = []
    for family in FAMILIES:
        for delay in FAMILY_STEPS:
            overrides = {"drive": {"latency_steps": delay}}
            found = means(
                evaluate(
                    "fuzzy_expert", f"hazbot_gym/{family}-v1", episodes=episodes,
                    overrides=overrides,
                )
            )  # fmt: skip
            named = {name: found[name] for name in FAMILY_METRICS}
            rows.append({"family": family, "delay_s": DECISION_S * delay, **named})
    return rows
