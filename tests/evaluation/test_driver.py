"""A policy is refused where the robot is another one, in one line."""

from __future__ import annotations

from typing import Any

import gymnasium
import pytest

from hazbot_gym import evaluate, make_policy, run_episode
from hazbot_gym.config import make_config
from hazbot_gym.evaluation.driver import check_made_for
from tests.refusals import refused

FAST: dict[str, Any] = {"drive": {"nominal_speed_mps": 1.5}}
SLOWLY: dict[str, Any] = {"clock": {"decision_s": 0.2}}
GAS: dict[str, Any] = {"gas": {}}


@pytest.mark.parametrize(
    ("spec", "values", "said"),
    [
        ("ppo", FAST, "drive.nominal_speed_mps: given 1.5 ... ppo ... 0.5"),
        ("ppo", SLOWLY, "clock.decision_s: given 0.2 ... ppo ... 0.1"),
        ("ssm", FAST, "1.5 ... ssm ... 0.5 ... nominal_mps=1.5"),
        ("shielded:policy=ppo", FAST, "1.5 ... 0.5"),
        ("shielded:policy=fuzzy_expert", FAST, "1.5 ... 0.5"),
        ("slow_on_rise:people=mpc", FAST | GAS, "1.5 ... 0.5"),
        ("fuzzy_reading:reading=recursive", FAST, "1.5 ... 0.5"),
    ],
)
def test_another_robot_is_refused(spec: str, values: dict[str, Any], said: str) -> None:
    with refused(said):
        check_made_for(make_policy(spec), make_config(**values), spec)


@pytest.mark.parametrize(
    ("spec", "values"),
    [
        ("ppo", {}),
        ("ppo", {"tier": "sonar"}),
        ("ssm:nominal_mps=1.5", FAST),
        ("fuzzy_expert", FAST),  # it answers in shares of the nominal speed
        ("fuzzy_reading:reading=inverted", FAST),
        ("ssm", SLOWLY),
        ("shielded:by=ssm:nominal_mps=1.5,policy=fuzzy_expert", FAST),
        ("slow_on_rise:people=none", FAST | GAS),
    ],
)
def test_the_same_robot_is_not(spec: str, values: dict[str, Any]) -> None:
    check_made_for(make_policy(spec), make_config(**values))


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_evaluations_refuse_it(engine: str) -> None:
    with refused("1.5 ... ppo ... 0.5"):
        evaluate("ppo", "hazbot_gym/Corridor-v1", episodes=1, overrides=FAST, engine=engine)


def test_single_episodes_refuse_it() -> None:
    env = gymnasium.make("hazbot_gym/Corridor-v1", **FAST)
    with refused("1.5 ... 0.5"):
        run_episode(env, make_policy("ppo"), seed=0)
