"""Policies read observations with other person slots and rings, where the environment is known."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import evaluate, make_policy
from hazbot_gym.config import make_config
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.task.observation import LAYOUTS, layout_in, observing, selected
from tests.refusals import refused

CROWD: dict[str, Any] = {"people": {"count": [6, 7]}}
FIVE: dict[str, Any] = {**CROWD, "person_slots": 5}
ANGLES = (0.0, 0.7, -0.7, 1.57, -1.57)
RING = [{"name": f"s{i}", "angle_rad": angle} for i, angle in enumerate(ANGLES)]


def returns(policy: str, *, engine: str = "batched", **overrides: Any) -> list[float]:
    rows = evaluate(
        policy, "hazbot_gym/Corridor-v1", episodes=3, overrides=overrides, engine=engine
    )
    return [row["return"] for row in rows]


def an_actor(folder: Path, **values: Any) -> str:
    """Return the spec of a random network for the observations of an environment."""
    config = make_config(**values)
    layout, rng = layout_in(config), np.random.default_rng(1)
    weight = rng.normal(scale=0.1, size=(layout.width, 1)).astype(np.float32)
    actor = Actor((Layer(weight, np.zeros(1, np.float32)),), "tanh", "clipped")
    with (folder / "policy.npz").open("wb") as file:
        write(describe(actor, algorithm="PPO", tier=config.tier, layout=layout), file)
    return f"learned:path={folder / 'policy.npz'}"


@pytest.mark.parametrize("policy", ["fuzzy_expert", "social_force", "idm", "ppo"])
def test_both_engines_run_it_alike(policy: str) -> None:
    expected = returns(policy, **FIVE)
    assert returns(policy, engine="pymunk", **FIVE) == pytest.approx(expected, abs=1e-6)


def test_a_trained_policy_drives_as_with_the_slots_of_its_training() -> None:
    assert returns("ppo", **FIVE) == returns("ppo", **CROWD)
    with refused("person_slots ... 2 ... 'ppo'"):
        returns("ppo", person_slots=2)


def test_a_file_holds_its_observation(tmp_path: Path) -> None:
    spec = an_actor(tmp_path, sensors={"ring": RING}, person_slots=5)
    policy, rng = make_policy(spec), np.random.default_rng(0)
    config = make_config(sensors={"ring": RING}, person_slots=6, gas={})
    rows = rng.uniform(0.0, 1.0, (4, layout_in(config).width)).astype(np.float32)
    with observing(config):
        actions, _ = policy.predict(rows)
        own = selected(rows, layout_in(make_config(sensors={"ring": RING}, person_slots=5)))
    with observing(make_config(sensors={"ring": RING}, person_slots=5)):
        assert np.array_equal(policy.predict(own)[0], actions)
    with refused("person_slots ... 3 ... 5"):
        returns(spec, sensors={"ring": RING})
    with refused("sensors.ring ... 4 ... 5"):
        returns(spec, person_slots=5)
    with refused(f"{own.shape[1]} ... observing"):
        policy.predict(own)


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
def test_rules_run_with_a_ring_of_ones_own(tier: str) -> None:
    assert len(returns("fuzzy_expert", tier=tier, sensors={"ring": RING})) == 3


def test_echoes_need_a_sensor_at_each_side() -> None:
    with refused("sensors.ring ... each side"):
        returns("fuzzy_expert", tier="sonar", sensors={"ring": RING[:3]})


def test_an_invalid_entry_of_any_slot_stops_the_robot() -> None:
    config = make_config(person_slots=5)
    layout = layout_in(config)
    rows = np.zeros((layout.width, layout.width), np.float32)
    np.fill_diagonal(rows, np.nan)
    with observing(config):
        actions, _ = make_policy("fuzzy_expert").predict(rows)
        assert (actions == -1.0).all()
        assert make_policy("constant:1").predict(np.zeros(layout.width, np.float32))[0] == 1.0


def test_more_slots_tell_a_rule_of_more_people() -> None:
    """Slots nearer than the last are the same, so a rule is slowed by the added people only."""
    config = make_config(person_slots=5)
    layout, rng = layout_in(config), np.random.default_rng(2)
    rows = np.tile(np.zeros(layout.width, np.float32), (200, 1))
    for i, name in itertools.product(range(5), ("present", "distance_m", "speed_mps")):
        column = layout.names.index(f"person{i}_{name}")
        rows[:, column] = 1.0 if name == "present" else rng.uniform(0.0, 0.4, 200)
    expert = make_policy("fuzzy_expert")
    three = expert.predict(selected_default(rows, config))[0]
    with observing(config):
        five = expert.predict(rows)[0]
    assert (five <= three).all()
    assert (five < three).any()


def selected_default(rows: Any, config: Any) -> Any:
    """Return the observations with three slots."""
    with observing(config):
        return selected(rows, LAYOUTS["tracks"])
