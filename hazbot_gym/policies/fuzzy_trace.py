"""Trace of the fuzzy expert: memberships and fired rules for each person, for views of it."""

from __future__ import annotations

from typing import NamedTuple

from hazbot_gym.core.fuzzy import kept_fraction, two_sided_gauss, weight_in
from hazbot_gym.core.state import CROSSING, NO_PATTERN, PATTERN_NAMES
from hazbot_gym.policies.fuzzy_expert import DISTANCE_TERMS, RULES, SPEED_TERMS, FuzzyExpert
from hazbot_gym.policies.guard import Observations
from hazbot_gym.task.observation import layout_of

LEAST_WEIGHT = 0.01  # of a rule that is told


class FiredRule(NamedTuple):
    """A rule that fires: its terms, its speed factor and its weight."""

    distance: str
    speed: str
    pattern: str
    kept: str
    weight: float


class PersonTrace(NamedTuple):
    """Conclusions of the expert from one person.

    Attributes:
        distance_m: R_r, between the centres.
        speed_mps: The person's speed V_j.
        pattern: Name of the walking pattern, or "".
        distance: Membership of each term of the distance.
        speed: Membership of each term of the speed.
        rules: Fired rules, the strongest first; none within R_s and beyond R_max, where no rule is
            asked.
        kept: Speed factor for this person.
    """

    distance_m: float
    speed_mps: float
    pattern: str
    distance: dict[str, float]
    speed: dict[str, float]
    rules: tuple[FiredRule, ...]
    kept: float


def trace(expert: FuzzyExpert, observation: Observations) -> list[PersonTrace]:
    """Return the conclusions from each person in an observation (n,), with default distances.

    The observation has people (``PeopleRule.with_estimates``). The expert's speed factor is the
    smallest of all people's, 1 without any.
    """
    layout, found = layout_of(observation), []
    seen = layout.decode(observation)
    for slot in range(layout.person_slots):
        person = f"person{slot}_"
        if seen[f"{person}present"] > 0.5:
            flags = [bool(seen[person + name] > 0.5) for name in PATTERN_NAMES]
            pattern = CROSSING + flags.index(True) if any(flags) else NO_PATTERN
            distance_m, speed_mps = seen[f"{person}distance_m"], seen[f"{person}speed_mps"]
            found.append(_person(expert, float(distance_m), float(speed_mps), pattern))
    return found


def _person(expert: FuzzyExpert, distance_m: float, speed_mps: float, pattern: int) -> PersonTrace:
    controller, rules = expert.controller, RULES[expert.rules]
    fired = []
    if controller.sensitive_m < distance_m <= controller.avoidance_m:
        for j, names in enumerate(rules):
            weight = float(weight_in(j, distance_m, speed_mps, pattern, controller))
            if weight >= LEAST_WEIGHT:
                fired.append(FiredRule(names[0], names[1], names[2], names[3], weight))
    return PersonTrace(
        distance_m,
        speed_mps,
        PATTERN_NAMES[pattern] if pattern >= 0 else "",
        {name: float(two_sided_gauss(distance_m, *term)) for name, term in DISTANCE_TERMS.items()},
        {name: float(two_sided_gauss(speed_mps, *term)) for name, term in SPEED_TERMS.items()},
        tuple(sorted(fired, key=lambda rule: -rule.weight)),
        float(kept_fraction(distance_m, speed_mps, pattern, controller)),
    )
