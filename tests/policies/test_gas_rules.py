"""Rules about gas, alone and beside a rule about people."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.task.observation import layout_for
from tests.gas_columns import without_gas
from tests.refusals import refused

Maker = Callable[..., Any]
RULES = ("slow_on_rise", "undo_lag")
PEOPLE = ("fuzzy_expert", "idm", "mpc", "ssm", "velocity_obstacle")
EAGER = {"slow_on_rise": "rise_per_s=-5", "undo_lag": "level=-10,lag_s=0"}  # inspects always
TRACKS = layout_for("tracks", has_gas=True)


def smelling(tier: str = "tracks", **values: float) -> Any:
    """Return the observation of a robot that smells, with nobody near."""
    layout = layout_for(tier, has_gas=True)
    row = np.zeros(layout.width, np.float32)
    far = {name: 4.0 for name in layout.names if name.startswith("range_")}
    far |= {n: 8.0 for n in layout.names if n.endswith(("distance_m", "closest_s", "closest_m"))}
    for name, value in {**far, "speed_mps": 0.5, "command_mps": 0.5, **values}.items():
        column = layout.names.index(name)
        row[column] = value / layout.fields[column].scale
    return row


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize("rule", RULES)
def test_observations_without_gas_are_refused_in_a_line(rule: str, tier: str, seen: Maker) -> None:
    with refused("gas ... sensor ... Inspection-v1"):
        policies.make(rule).predict(seen(tier))


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize(
    ("rate_per_s", "expected"), [(-1.0, 1.0), (0.0, 1.0), (0.29, 1.0), (0.31, 0.25), (4.0, 0.25)]
)
def test_slow_on_rise_is_slow_while_the_reading_rises_faster_than_the_threshold(
    rate_per_s: float, expected: float, tier: str, share: Maker
) -> None:
    rule = policies.make("slow_on_rise:rise_per_s=0.3,slow=0.25")
    for reading in (0.0, 5.0):
        observation = smelling(tier, gas_reading=reading, gas_rate_per_s=rate_per_s)
        assert share(rule, observation) == pytest.approx(expected)


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize(
    ("reading", "rate_per_s", "expected"),
    [
        (0.69, 0.0, 1.0),
        (0.71, 0.0, 0.1),
        (0.0, 0.34, 1.0),
        (0.0, 0.36, 0.1),
        (2.0, -0.7, 1.0),  # the gas is gone, though not the reading
        (-0.5, 0.61, 0.1),
    ],
)
def test_undo_lag_is_slow_while_the_sensor_heads_for_more_than_the_level(
    reading: float, rate_per_s: float, expected: float, tier: str, share: Maker
) -> None:
    rule = policies.make("undo_lag:level=0.7,lag_s=2,slow=0.1")
    observation = smelling(tier, gas_reading=reading, gas_rate_per_s=rate_per_s)
    assert share(rule, observation) == pytest.approx(expected)


@pytest.mark.parametrize("rule", RULES)
def test_after_an_alarm_there_is_nothing_to_slow_down_for(rule: str, share: Maker) -> None:
    policy = policies.make(f"{rule}:{EAGER[rule]},slow=0.3")
    assert share(policy, smelling(gas_alarmed=0.0)) == pytest.approx(0.3)
    assert share(policy, smelling(gas_alarmed=1.0)) == 1.0


@pytest.mark.parametrize("people", PEOPLE)
@pytest.mark.parametrize("rule", RULES)
def test_beside_a_rule_about_people_the_slower_of_both_counts(
    rule: str, people: str, seen: Maker
) -> None:
    rows = seen("tracks", has_gas=True)[:300]
    gas, both = (policies.make(f"{rule}:slow=0.5{end}") for end in ("", f",people={people}"))
    alone, other = gas.predict(rows)[0], policies.make(people).predict(without_gas(rows))[0]
    assert both.predict(rows)[0] == pytest.approx(np.minimum(alone, other), abs=1e-6)
    assert (alone < other).any()
    assert (other < alone).any()


@pytest.mark.parametrize("people", PEOPLE)
@pytest.mark.parametrize("rule", RULES)
def test_on_sonar_people_are_remembered_as_by_the_rule_about_people(rule: str, people: str) -> None:
    """Somebody comes, while the gas rises in every other decision."""
    both, other = policies.make(f"{rule}:slow=0.6,people={people}"), policies.make(people)
    state = memory = None
    slowed = 0
    for k in range(9):
        echo = {f"range_front_{side}_m": 2.1 - 0.18 * k for side in ("left", "right")}
        aside = {"range_left_m": 0.9, "range_right_m": 0.9}
        row = smelling("sonar", **echo, **aside, gas_rate_per_s=5.0 * (k % 2))
        action, state = both.predict(row, state)
        expected, memory = other.predict(without_gas(row), memory)
        slow = 0.2 if k % 2 else 1.0
        assert action[0] == pytest.approx(min(expected[0], slow), abs=1e-6)
        slowed += expected[0] < slow
    assert slowed > 0


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_about_people_that_is_none_is_refused(rule: str) -> None:
    with refused("people ... 'waltz' ... 'ssm'"):
        policies.make(f"{rule}:people=waltz")


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize("spec", [*PEOPLE, "constant:0.25", "stop_on_sight", "social_force", "ttc"])
def test_rules_about_people_do_not_smell(spec: str, tier: str, seen: Maker) -> None:
    rows = seen(tier, has_gas=True)[:100]
    policy = policies.make(spec)
    assert np.array_equal(policy.predict(rows)[0], policy.predict(without_gas(rows))[0])


# --- trained policies ----------------------------------------------------------------------------


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
def test_the_shipped_policy_drives_among_gas_as_without(tier: str, seen: Maker) -> None:
    rows, policy = seen(tier, has_gas=True)[:50], policies.make("ppo")
    assert np.array_equal(policy.predict(rows)[0], policy.predict(without_gas(rows))[0])
    env = CorridorEnv(tier=tier, gas={})
    state, (observation, info) = None, env.reset(seed=3)
    with_gas, without = [], []
    memory: Any = None
    while info["outcome"] == "running":
        action, state = policy.predict(observation, state)
        other, memory = policy.predict(without_gas(observation), memory)
        with_gas.append(float(action[0]))
        without.append(float(other[0]))
        observation, *_, info = env.step(action)
    assert info["outcome"] == "arrived"
    assert with_gas == without


def trained_with_gas(folder: Path) -> str:
    """Return the spec of a network that drives fast where the reading is high."""
    weight = np.zeros((TRACKS.width, 1), np.float32)
    weight[TRACKS.names.index("gas_reading")] = 5.0
    actor = Actor((Layer(weight, np.zeros(1, np.float32)),), "tanh", "clipped")
    with (folder / "gas.npz").open("wb") as file:
        write(describe(actor, algorithm="PPO", tier="tracks"), file)
    return f"learned:path={folder / 'gas.npz'}"


def test_a_policy_trained_with_gas_smells_it_and_needs_it(
    tmp_path: Path, seen: Maker, share: Maker
) -> None:
    policy = policies.make(trained_with_gas(tmp_path))
    assert share(policy, smelling(gas_reading=-2.0)) < share(policy, smelling(gas_reading=2.0))
    with refused("gas ... without"):
        policy.predict(seen("tracks"))


# --- in the environment --------------------------------------------------------------------------


@pytest.mark.parametrize("spec", ["slow_on_rise", "undo_lag:people=ssm"])
@pytest.mark.parametrize("tier", ["sonar", "tracks"])
def test_rules_drive_through_an_inspection(spec: str, tier: str) -> None:
    rows = evaluate(spec, "hazbot_gym/InspectionEmpty-v1", episodes=3, overrides={"tier": tier})
    assert means(rows)["arrived"] == 1.0


def test_whoever_inspects_takes_longer() -> None:
    spans = [
        means(evaluate(spec, "hazbot_gym/InspectionEmpty-v1", episodes=4, seed=1))["delay_s"]
        for spec in ("constant", "slow_on_rise:rise_per_s=0.02", "slow_on_rise:rise_per_s=-5")
    ]
    assert spans[0] < spans[1] < spans[2]
