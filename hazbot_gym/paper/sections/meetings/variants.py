"""Variants of the encounters that the paper leaves open: widths of terms, "stopped", front wall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.config import make_config
from hazbot_gym.core.fuzzy import kept_fraction
from hazbot_gym.core.state import ENCOUNTERING, ROBOT_RADIUS_M
from hazbot_gym.paper.sections.meetings.experiment import STOPPED, Meeting, meet, slows_for_good_s
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M
from hazbot_gym.policies.fuzzy_readings import FuzzyReading
from hazbot_gym.utils.json_object import JsonObject

# Definitions of "stopped", as a share of the nominal speed.
BELOW = {"10 %": 0.1, "5 %": STOPPED, "nil": 1e-9}
CHOSEN, WIDE = "as chosen, neighbours cross at a half", "all 0.25 m wide"
REFIT = f"{WIDE}, and a crossing for them"
_WIDTH = FuzzyReading(reading="width")
_HEADING_RAD = math.radians(-66.66)
_FROM_THERE = {  # the crossing fitted to these widths
    "x_m": 2.996,
    "y_m": 4.613,
    "vx_mps": 0.5 * math.cos(_HEADING_RAD),
    "vy_mps": 0.5 * math.sin(_HEADING_RAD),
}
WALL = "C-experiment+wall"


def by_width() -> dict[str, dict[str, Meeting]]:
    """Return both simulations by the widths of the distance terms, and a matching start."""
    there = {"people": {"walkers": [_FROM_THERE]}}
    ways: dict[str, tuple[Any, JsonObject]] = {
        CHOSEN: ("fuzzy_expert", {}),
        WIDE: (_WIDTH, {}),
        REFIT: (_WIDTH, there),
    }
    return {
        name: {"C*": meet("C*", policy, overrides=crossing)[0], "E*": meet("E*", policy)[0]}
        for name, (policy, crossing) in ways.items()
    }


def jump_of_wide_terms() -> float:
    """Return the share of its speed that the robot loses at once at 3.0 m with wide terms."""
    return 1.0 - kept_fraction(AVOIDANCE_M, 0.5, ENCOUNTERING, _WIDTH.controller)


class Wall(NamedTuple):
    """End of the crossing experiment before a wall: means over seeds."""

    stands_at_m: float  # the wall, along the robot's path
    slows_s: float  # when the robot leaves its nominal speed for the last time
    gap_m: float  # between the robot's body and the wall in the end


def front_wall(seeds: Sequence[int]) -> Wall:
    """Run the crossing experiment with a wall across the robot's way."""
    place = make_config(scenario=WALL).place_options
    wall_m = place["length_m"] + place["end_wall_m"]
    ends = [(slows_for_good_s(run), wall_m - run.x[-1]) for run in meet(WALL, seeds=seeds)]
    slows_s, apart_m = np.mean(ends, axis=0)
    return Wall(wall_m, float(slows_s), float(apart_m) - ROBOT_RADIUS_M)
