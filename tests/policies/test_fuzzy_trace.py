"""The trace says what the expert does: its rules and memberships give its speed factor."""

from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.policies.fuzzy_expert import KEPT_TERMS, FuzzyExpert
from hazbot_gym.policies.fuzzy_trace import trace
from hazbot_gym.task.observation import LAYOUTS

EXPERT = FuzzyExpert()
LAYOUT = LAYOUTS["tracks"]


def observation(*people: tuple[float, float, str]) -> np.ndarray:
    """Return an observation of people at a distance [m] with a speed [m/s] and a pattern."""
    seen = {name: 0.0 for name in LAYOUT.names}
    for slot, (distance_m, speed_mps, pattern) in enumerate(people):
        person = f"person{slot}_"
        seen |= {f"{person}present": 1.0, f"{person}distance_m": distance_m}
        seen |= {f"{person}speed_mps": speed_mps, f"{person}{pattern}": 1.0}
    return LAYOUT.encode(seen)


@pytest.mark.parametrize("pattern", PATTERN_NAMES)
@pytest.mark.parametrize("distance_m", [1.2, 1.8, 2.4, 2.9, 3.4])
def test_the_weighted_mean_of_the_rules_is_the_speed_factor(
    distance_m: float, pattern: str
) -> None:
    seen = observation((distance_m, 1.0, pattern))
    (person,) = trace(EXPERT, seen)
    assert person.kept == pytest.approx(float(np.asarray(EXPERT.speed_share(seen))), abs=1e-6)
    if person.rules:
        weights = [rule.weight for rule in person.rules]
        kept = [KEPT_TERMS[rule.kept] for rule in person.rules]
        assert np.average(kept, weights=weights) == pytest.approx(person.kept, abs=0.02)
    else:
        assert person.kept in (0.0, 1.0)


def test_the_expert_drives_as_the_slowest_conclusion_allows() -> None:
    seen = observation((2.8, 1.2, "leading"), (2.0, 1.2, "confronting"))
    people = trace(EXPERT, seen)
    assert [person.pattern for person in people] == ["leading", "confronting"]
    slowest = min(person.kept for person in people)
    assert slowest == pytest.approx(float(np.asarray(EXPERT.speed_share(seen))), abs=1e-6)
    assert people[0].distance["DN"] > people[1].distance["DN"]
