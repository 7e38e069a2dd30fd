"""Experiments with all readings of the fuzzy strategy that the paper's text allows.

The criteria of unsafe and degenerate below were stated before any run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from hazbot_gym.paper.sections.meetings.experiment import Events, events, meet

SCENARIOS = ("E*", "C*")
LONG_S = 1.0  # time of motion within 1.5 m of a human that is unsafe
EARLY_S = 0.2  # two decisions: slow beyond 3.0 m for longer is too early
ASTRAY_S = 5.0  # slow beyond 3.0 m for longer is unrelated to distance


class Reading(NamedTuple):
    """A reading of the paper, as a policy."""

    name: str
    policy: str
    overrides: Mapping[str, object] = {}


def _other(name: str, reading: str) -> Reading:
    return Reading(name, f"fuzzy_reading:reading={reading},release=true")


READINGS = (
    Reading("32 rules, recovery with distance alone (chosen)", "fuzzy_expert"),
    Reading("32 rules, human behind and receding let go", "fuzzy_expert:release=true"),
    Reading("8 printed rules, crisp pattern", "fuzzy_expert:rules=literal8,release=true"),
    Reading(
        "8 printed rules, Gaussian pattern",
        "fuzzy_expert:rules=literal8,pattern=gaussian,release=true",
    ),
    _other("Gaussian pattern", "gaussian"),
    _other("Mamdani centroid", "centroid"),
    _other("percentages are taken away", "inverted"),
    _other("v(t) is the present speed", "recursive"),
    _other("no limit and no shoulder at 3.0 m", "no_gate"),
    _other("eq 8b, t = 1 s", "horizon"),
    _other("eq 8b, t = elapsed time", "elapsed"),
    _other("75 and 90 % of the way from 1.5 to 3.0 m", "span"),
    _other("all terms of distance 0.25 m wide", "width"),
    _other("slow and fast divided at 0.5 m/s", "split"),
    Reading("four ultrasonic sensors instead of tracked people", "fuzzy_expert", {"tier": "sonar"}),
)
# A head-on person: rules 7 and 8 of the paper only cover DF.
HEAD_ON = {
    "people": {"walkers": [{"x_m": 4.479, "y_m": 0.0, "vx_mps": -0.5, "vy_mps": 0.0}]},
}
HEAD_ON_POLICIES = {
    "8 printed rules": "fuzzy_expert:rules=literal8",
    "32 rules": "fuzzy_expert",
}


def run(reading: Reading) -> dict[str, Events]:
    """Run a reading in both scenarios."""
    return {
        scenario: events(meet(scenario, reading.policy, overrides=reading.overrides)[0])
        for scenario in SCENARIOS
    }


def verdict(found: Mapping[str, Events]) -> str:
    """Return the defect of a reading, or "works"."""
    faults = []
    if any(each.hits for each in found.values()):
        faults.append("unsafe: drives into the human")
    elif any(each.moving_inside_s > LONG_S for each in found.values()):
        faults.append(f"unsafe: moves within 1.5 m for more than {LONG_S:g} s")
    elif any(each.moving_inside_s > 0.0 for each in found.values()):
        faults.append("moves within 1.5 m")
    if math.isnan(found["E*"].stops_s):
        faults.append("degenerate: never stops although the human comes to 0.8 m")
    outside_s = max(each.slow_outside_s for each in found.values())
    if any(math.isnan(each.recovers_s) and not each.hits for each in found.values()):
        faults.append("degenerate: never recovers")
    elif outside_s > ASTRAY_S:
        faults.append(f"degenerate: slow for {outside_s:.1f} s with the human beyond 3.0 m")
    elif outside_s > EARLY_S:
        faults.append(f"slow for {outside_s:.1f} s with the human beyond 3.0 m")
    return "; ".join(faults) or "works"


def head_on() -> dict[str, Events]:
    """Run the encounter with a head-on person."""
    return {
        name: events(meet("E*", policy, overrides=HEAD_ON)[0])
        for name, policy in HEAD_ON_POLICIES.items()
    }
