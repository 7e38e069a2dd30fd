from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym import policies
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.policies.people_rule import with_people
from hazbot_gym.task.observation import LAYOUTS, PERSON_SLOTS

SONAR, TRACKS = LAYOUTS["sonar"], LAYOUTS["tracks"]
RULES = (
    "fuzzy_expert",
    "ssm",
    "ssm:mode=directional",
    "ttc",
    "social_force:strength=16",
    "hall_steps",
    "passive_safety",
    "velocity_obstacle",
)
BRAKING = ("idm", "mpc")  # not more than the robot can


def hears(front_m: npt.ArrayLike, v: float = 0.5) -> npt.NDArray[np.float32]:
    """Return sonar observations (..., n) of a corridor with something in both cones in front."""
    row = np.zeros((*np.shape(front_m), SONAR.width))
    values = {"range_front_left_m": front_m, "range_front_right_m": front_m, "speed_mps": v}
    values |= {"range_left_m": 0.9, "range_right_m": 0.9, "command_mps": v}
    for name, value in values.items():
        column = SONAR.names.index(name)
        row[..., column] = np.asarray(value) / SONAR.fields[column].scale
    return row.astype(np.float32)


def shares(policy: Any, observations: Any, state: Any = None) -> list[float]:
    result = []
    for observation in observations:
        action, state = policy.predict(observation, state)
        result.append(float(action[0] + 1.0) / 2.0)
    return result


@pytest.mark.parametrize("spec", RULES)
def test_rule_slows_down_on_sonar_for_who_comes_and_not_for_the_corridor(spec: str) -> None:
    policy = policies.make(spec)
    assert shares(policy, [hears(2.245)] * 30) == [1.0] * 30
    # All but stops at a clearance of 0.9 m: somebody comes at 1.3 m/s, heard for half a second.
    assert shares(policy, [hears(2.1 - 0.18 * k) for k in range(7)])[-1] < 0.5


@pytest.mark.parametrize("spec", BRAKING)
def test_rule_brakes_on_sonar_for_who_comes_and_not_for_the_corridor(spec: str) -> None:
    policy = policies.make(spec)
    assert shares(policy, [hears(2.245)] * 30) == [1.0] * 30
    assert shares(policy, [hears(2.1 - 0.18 * k) for k in range(7)])[-1] < 0.7


@pytest.mark.parametrize("spec", [*RULES, *BRAKING])
def test_stacked_sonar_observations_get_the_actions_of_each(spec: str) -> None:
    policy = policies.make(spec)
    readings = 2.1 - np.outer(np.arange(9), [0.18, 0.1, 0.0, 0.02])
    state, stacked = None, []
    for row in readings:
        actions, state = policy.predict(hears(row), state)
        assert actions.shape == (4, 1)
        stacked.append((actions[:, 0] + 1.0) / 2.0)

    alone = [shares(policy, [hears(reading) for reading in column]) for column in readings.T]
    np.testing.assert_allclose(np.array(stacked).T, alone, atol=1e-6)


def test_an_episode_begins_with_nobody_remembered() -> None:
    policy = policies.make("fuzzy_expert")
    state = None
    for k in range(6):
        action, state = policy.predict(hears([2.1 - 0.18 * k] * 2), state)
    lost = hears([2.245] * 2)
    action, _ = policy.predict(lost, state, np.array([False, True]))

    assert action[0, 0] < 0.0  # carried on
    assert action[1, 0] == 1.0


@pytest.mark.parametrize(
    ("scenario", "tier", "ring", "outcome"),
    [
        ("E*", "sonar", "paper", "arrived"),
        ("C*", "sonar", "paper", "arrived"),
        ("C90", "tracks", "paper", "arrived"),
        ("C90", "sonar", "paper", "contact_person"),  # at a bearing of 45 deg all the way
        ("C90", "sonar", "six", "arrived"),
        ("E*", "sonar", "six", "arrived"),
    ],
)
def test_fuzzy_expert_on_sonar_misses_who_comes_in_the_blind_sector_alone(
    scenario: str, tier: str, ring: str, outcome: str
) -> None:
    (row,) = evaluate(
        "fuzzy_expert",
        "hazbot_gym/Corridor-v1",
        episodes=1,
        overrides={"scenario": scenario, "tier": tier, "sensors": {"ring": ring}},
    )
    assert row["outcome"] == outcome


def test_nearest_people_fill_the_slots_in_the_units_of_the_tracker() -> None:
    observation = hears([1.0, 1.0])
    found = {
        "present": np.array([[1.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]]),
        "distance_m": np.array([[2.0, 0.1, 1.0, 3.0], [1.0, 1.0, 1.0, 1.0]]),
        "closing_mps": np.array([[0.2, 9.0, 0.1, 0.3], [1.0, 1.0, 1.0, 1.0]]),
    }
    full = with_people(observation, found)
    seen = TRACKS.decode(full)

    assert np.array_equal(full[:, : SONAR.width], observation)
    for name, expected in {"present": [1, 1, 1], "distance_m": [1, 2, 3]}.items():
        values = [seen[f"person{i}_{name}"][0] for i in range(PERSON_SLOTS)]
        assert values == pytest.approx(expected)
    assert seen["person0_closing_mps"] == pytest.approx([0.1, 0.0])
    assert not any(seen[f"person{i}_present"][1] for i in range(PERSON_SLOTS))
