"""The paper's encounters, driven by its fuzzy strategy through the whole environment."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.state import Floats
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert
from hazbot_gym.task.observation import layout_of

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "behaviour.json").read_text(encoding="utf-8")
)
SCENARIOS = REFERENCE["scenarios"]
DECELERATES, STOPS = 0.98, 0.05  # shares of the nominal speed


@functools.cache
def commands(scenario: str, rules: str = "complete32") -> Floats:
    """Return the commanded speeds of an episode [m/s], the k-th at time 0.1 k s."""
    env = gymnasium.make("hazbot_gym/Corridor-v1", scenario=scenario)
    expert = FuzzyExpert(rules=rules)  # type: ignore[arg-type]
    observation, _ = env.reset(seed=0)
    speeds, is_over = [], False
    while not is_over:
        action, _ = expert.predict(observation)
        observation, _, terminated, truncated, _ = env.step(action)
        speeds.append(env.unwrapped.snapshot().command_mps)  # type: ignore[attr-defined]
        is_over = terminated or truncated
    return np.array(speeds)


def first_below(speeds: Floats, share: float) -> float:
    """Return the time at which a command first is below a share of the nominal speed [s]."""
    below = speeds < share * REFERENCE["nominal_speed_mps"]
    assert below.any()
    return float(np.argmax(below)) * REFERENCE["dt_s"]


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_expert_decelerates_and_stops_when_the_paper_says(name: str) -> None:
    within = pytest.approx
    published, speeds = SCENARIOS[name], commands(name)
    tolerance = REFERENCE["tolerance_s"] + 1e-9
    assert first_below(speeds, DECELERATES) == within(published["decelerates_s"], abs=tolerance)
    assert first_below(speeds, STOPS) == within(published["stops_s"], abs=tolerance)


@pytest.mark.parametrize("name", ["E*", "C*"])
def test_the_expert_is_at_full_speed_again_when_the_paper_says(name: str) -> None:
    speeds = commands(name)
    slow = speeds < DECELERATES * REFERENCE["nominal_speed_mps"]
    recovers_s = (np.flatnonzero(slow)[-1] + 1) * REFERENCE["dt_s"]
    assert recovers_s == pytest.approx(SCENARIOS[name]["recovers_s"], abs=0.2)


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_walker_is_labelled_as_the_scenario_says(name: str) -> None:
    env = gymnasium.make("hazbot_gym/Corridor-v1", scenario=name)
    observation, _ = env.reset(seed=0)
    label = f"person0_{SCENARIOS[name]['pattern']}"
    seen = []
    for _ in range(60):
        seen.append(layout_of(observation).decode(observation)[label])
        observation = env.step(np.ones(1))[0]
    assert max(seen) == 1.0


def test_the_eight_printed_rules_never_stop_before_somebody_who_comes_towards() -> None:
    slowest = commands("E*", "literal8").min()
    assert slowest >= 0.18
    assert slowest == pytest.approx(REFERENCE["literal8_minimum_E*"], abs=0.01)
