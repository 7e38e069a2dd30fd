"""Definition of the scenario bank's sets: environment, people, number of scenarios.

A study names them ``bank:test``, ``bank:ood/faster`` or ``bank:test/Crossing``: a group, all groups
of a split, or a single set. Values are literal numbers and do not follow the defaults of
``config``, so that the frozen scenarios stay fixed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from hazbot_gym.config.deltas import merge
from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.envs.registration import NAMESPACE
from hazbot_gym.errors import InvalidInput

PREFIX = "bank:"  # of names in a study's ``sets``
ROOT = 20261204  # root of the seeds of the bank's scenarios alone
MANY, FEW = 150, 60  # scenarios of a set
LEAKS = 600  # of a set with gas, where chance decides on many leaks

FAMILIES = (
    "Corridor", "Crossing", "Encountering", "Leading", "Confronting", "Circle", "Intersection",
    "Doorway", "Aisle",
)  # fmt: skip
PATTERNS = tuple(pattern.capitalize() for pattern in PATTERN_NAMES)
# Cyclic pairs: each pattern occurs once for the first person and once for the others.
PAIRS = tuple(zip(PATTERNS, (*PATTERNS[1:], PATTERNS[0]), strict=True))

# 1.3 times the defaults, with the same cap of 2.2 m/s
_FASTER = {"mean_mps": 1.742, "sd_mps": 0.338, "leader_low_mps": 0.195, "leader_high_mps": 0.585}
_BLIND = {"gain": 1.0, "range_m": 0.0, "attraction_mps2": 0.0}  # does not react before contact
_ROUGH = {  # noise: three times the default; misses 30 % of people instead of none
    "ultrasonic": {"noise_m": 0.09},
    "tracker": {"position_noise_m": 0.09, "velocity_noise_mps": 0.15, "dropout": 0.3},
}


class BankSet(NamedTuple):
    """A set of the bank; the fields are those of ``config.ScenarioSet``."""

    name: str
    env: str
    overrides: Mapping[str, object]
    episodes: int
    seed: int = ROOT


class Group(NamedTuple):
    """Group of related sets.

    Attributes:
        meaning: Purpose, or the difference from the training distribution.
        episodes: Number of scenarios per set.
        sets: Preset and overrides of each, by name.
    """

    meaning: str
    episodes: int
    sets: Mapping[str, tuple[str, Mapping[str, object]]]


def _in(presets: Iterable[str], **overrides: object) -> dict[str, tuple[str, Mapping[str, object]]]:
    """Return sets of presets with the same config overrides, under the presets' names."""
    return {preset: (preset, overrides) for preset in presets}


def _pair(first: str, second: str) -> tuple[str, Mapping[str, object]]:
    """Return a set in which the first person has one pattern and all others a second pattern."""
    mix = [float(pattern == second) for pattern in PATTERNS]
    return first, {"people": {"count": [2, 4], "mix": mix}}


GROUPS: dict[str, Group] = {
    "validation": Group("model selection", FEW, _in(FAMILIES)),
    "test": Group("final evaluation; not for development", MANY, _in(FAMILIES)),
    "ood/faster": Group("people walk 30 % faster", FEW, _in(PATTERNS, people={"speeds": _FASTER})),
    "ood/blind": Group("no one yields", FEW, _in(PATTERNS, people={"reactions": [_BLIND] * 4})),
    "ood/pairs": Group(
        "two walking patterns per scenario", FEW, {"+".join(pair): _pair(*pair) for pair in PAIRS}
    ),
    "ood/narrow": Group(
        "corridor 1.8 m wide instead of 2.4 m", FEW, _in(PATTERNS, place_options={"width_m": 1.8})
    ),
    "ood/sensors": Group(
        "three times the sensor noise, 30 % missed detections",
        FEW,
        _in(PATTERNS, sensors=_ROUGH),
    ),
    "ood/delay": Group("commands delayed by 0.3 s", FEW, _in(PATTERNS, drive={"latency_steps": 3})),
    "ood/places": Group(
        "narrower doorway, intersection and aisle",
        FEW,
        {
            "Doorway": ("Doorway", {"place_options": {"door_m": 1.0}}),
            "Intersection": ("Intersection", {"place_options": {"side_width_m": 1.4}}),
            "Aisle": ("Aisle", {"place_options": {"width_m": 1.9}}),
        },
    ),
    "ood/dense": Group(
        "6 to 10 people in a corridor instead of 2 to 5",
        FEW,
        _in(["Corridor"], people={"count": [6, 10]}),
    ),
    "gas/validation": Group("model selection, with a gas leak", FEW, _in(["Inspection"])),
    "gas/test": Group("final evaluation, with a gas leak", LEAKS, _in(["Inspection"])),
}

BANK_SETS = tuple(
    BankSet(f"{name}/{each}", f"{NAMESPACE}/{preset}-v1", overrides, group.episodes)
    for name, group in GROUPS.items()
    for each, (preset, overrides) in group.sets.items()
)


def size(group: Group) -> str:
    """Return the size of a group (sets, scenarios) as text."""
    return f"{len(group.sets)} x {group.episodes}"


def select(name: str, overrides: Mapping[str, object] | None = None) -> list[dict[str, object]]:
    """Return the sets of a split, a group or a name, as fields of ``config.ScenarioSet``.

    Args:
        name: Name of a set, or a prefix of names.
        overrides: Further config values, such as ``{"tier": "sonar"}``.

    Raises:
        InvalidInput: No set has this name.
    """
    found = [each for each in BANK_SETS if f"{each.name}/".startswith(f"{name}/")]
    if not found:
        allowed = ", ".join(PREFIX + group for group in GROUPS)
        raise InvalidInput(f"given {PREFIX + name!r}, allowed are {allowed}, or a set of these")
    return [
        {**each._asdict(), "overrides": merge(each.overrides, overrides or {})} for each in found
    ]
