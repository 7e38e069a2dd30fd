"""Which sets the scenario bank consists of: where, with whom, how many.

A study names them ``bank:test``, ``bank:ood/faster`` or ``bank:test/Crossing``: a group, all groups
of a split, or a single set. Figures stand here as numbers and do not follow the defaults of
``config.py``: what is frozen is not to move with them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from hazbot_gym.config import merge
from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.envs.registration import NAMESPACE
from hazbot_gym.errors import InvalidInput

PREFIX = "bank:"  # of names in a study's ``sets``
ROOT = 20261130  # of the seeds of the bank's scenarios, and of nothing else
MANY, FEW = 250, 100  # scenarios of a set

PATTERNS = tuple(pattern.capitalize() for pattern in PATTERN_NAMES)
# One follows the other, so that each pattern is once the first person's and once the others'.
PAIRS = tuple(zip(PATTERNS, (*PATTERNS[1:], PATTERNS[0]), strict=True))

# 1.3 times the defaults; as there, nobody walks faster than 2.2 m/s
_FASTER = {"mean_mps": 1.742, "sd_mps": 0.338, "leader_low_mps": 0.195, "leader_high_mps": 0.585}
_BLIND = {"gain": 1.0, "range_m": 0.0, "attraction_mps2": 0.0}  # notices nothing before it touches
_ROUGH = {  # noise: three times the default; the default tracker misses nobody, this one 3 of 10
    "ultrasonic": {"noise_m": 0.09},
    "tracker": {"position_noise_m": 0.09, "velocity_noise_mps": 0.15, "dropout": 0.3},
}


class BankSet(NamedTuple):
    """A set of the bank; the fields are those of ``config.ScenarioSet``."""

    name: str
    env: str
    overrides: Mapping[str, Any]
    episodes: int
    seed: int = ROOT


class Group(NamedTuple):
    """Sets that belong together.

    Attributes:
        meaning: What they are for, or what differs in them from what policies are trained on.
        episodes: How many scenarios each set has.
        sets: Preset and overrides of each, by name.
    """

    meaning: str
    episodes: int
    sets: Mapping[str, tuple[str, Mapping[str, Any]]]


def _in(presets: Iterable[str], **overrides: Any) -> dict[str, tuple[str, Mapping[str, Any]]]:
    """Return sets that differ from presets in the same config values, named as the presets are."""
    return {preset: (preset, overrides) for preset in presets}


def _pair(first: str, second: str) -> tuple[str, Mapping[str, Any]]:
    """Return a set in which the first person shows one pattern and all others another."""
    mix = [float(pattern == second) for pattern in PATTERNS]
    return first, {"people": {"count": [2, 4], "mix": mix}}


GROUPS: dict[str, Group] = {
    "validation": Group("to choose between policies while they are made", FEW, _in(PATTERNS)),
    "test": Group(
        "to be reported; met by nobody who makes policies", MANY, _in([*PATTERNS, "Corridor"])
    ),
    "ood/faster": Group("people walk 30 % faster", FEW, _in(PATTERNS, people={"speeds": _FASTER})),
    "ood/blind": Group(
        "people do not notice the robot", FEW, _in(PATTERNS, people={"reactions": [_BLIND] * 4})
    ),
    "ood/pairs": Group(
        "two patterns and no third", FEW, {"+".join(pair): _pair(*pair) for pair in PAIRS}
    ),
    "ood/narrow": Group("1.8 m wide, not 2.4", FEW, _in(PATTERNS, place_options={"width_m": 1.8})),
    "ood/sensors": Group(
        "sensor noise three times as strong, 3 of 10 sightings missed",
        FEW,
        _in(PATTERNS, sensors=_ROUGH),
    ),
    "ood/delay": Group(
        "commands obeyed 0.3 s late", FEW, _in(PATTERNS, drive={"latency_steps": 3})
    ),
    "ood/places": Group("places not trained in", FEW, _in(["Doorway", "Intersection", "Circle"])),
    "ood/dense": Group(
        "6 to 10 people, not 2 to 5", FEW, _in(["Corridor"], people={"count": [6, 10]})
    ),
}

BANK_SETS = tuple(
    BankSet(f"{name}/{each}", f"{NAMESPACE}/{preset}-v0", overrides, group.episodes)
    for name, group in GROUPS.items()
    for each, (preset, overrides) in group.sets.items()
)


def size(group: Group) -> str:
    """Return how many sets of how many scenarios a group has, in words for a list."""
    return f"{len(group.sets)} x {group.episodes}"


def select(name: str, overrides: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Return the sets of a split, a group or a name, as fields of ``config.ScenarioSet``.

    Args:
        name: What their names are or begin with.
        overrides: Further config values, such as ``{"tier": "sonar"}``.

    Raises:
        InvalidInput: There are none.
    """
    found = [each for each in BANK_SETS if f"{each.name}/".startswith(f"{name}/")]
    if not found:
        allowed = ", ".join(PREFIX + group for group in GROUPS)
        raise InvalidInput(f"given {PREFIX + name!r}, allowed are {allowed}, or a set of these")
    return [
        {**each._asdict(), "overrides": merge(each.overrides, overrides or {})} for each in found
    ]
