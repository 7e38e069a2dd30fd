from __future__ import annotations

import sys
import types
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.policies.base import REGISTER, Policy
from hazbot_gym.policies.constant import Constant
from hazbot_gym.policies.own_policy import OwnPolicy
from hazbot_gym.task.action import speed_action
from tests.refusals import refused

FROM_FILES = ("ppo", "learned", "shielded")  # test_learned.py and test_shielded.py make these


class Halves:
    """A policy of somebody else's."""

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        return np.zeros(1, dtype=np.float32), state


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("elsewhere")
    module.Halves, module.ready, module.nothing = Halves, Halves(), 3  # type: ignore[attr-defined]
    module.inside = types.SimpleNamespace(ready=Halves())  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "elsewhere", module)


@pytest.mark.parametrize("name", [name for name in REGISTER if name not in FROM_FILES])
def test_every_rule_of_the_register_can_be_made(name: str) -> None:
    assert isinstance(policies.make(name), Policy)


def test_every_policy_of_the_register_has_a_description() -> None:
    assert set(FROM_FILES) < set(REGISTER)
    assert all(policies.names()[name] for name in REGISTER)


@pytest.mark.parametrize(
    ("spec", "fraction"),
    [("constant", 1.0), ("constant:0.25", 0.25), ("constant:fraction=0.5", 0.5)],
)
def test_options_follow_the_name_with_or_without_their_own(spec: str, fraction: float) -> None:
    assert policies.make(spec) == Constant(fraction)


def test_code_is_run_only_where_that_is_allowed() -> None:
    with refused("'elsewhere:ready' ... --allow-code"):
        policies.make("elsewhere:ready", allow_code=False)


@pytest.mark.parametrize("spec", ["elsewhere:Halves", "elsewhere:ready", "elsewhere:inside.ready"])
def test_policy_of_one_s_own_is_an_object_or_what_makes_one(spec: str) -> None:
    made = policies.make(spec)
    assert isinstance(made, OwnPolicy)
    assert isinstance(made.policy, Halves)


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (
            "nobody",
            "'nobody' ... constant, random, stop_on_sight, stop_when_near, ssm",
        ),
        ("", "'' ... constant"),
        (":x", "':x'"),
        ("mine:", "'mine:'"),
        ("mine:1st", "'mine:1st'"),
        ("..mine:x", "is not known"),
        ("no_such_module:x", "'no_such_module'"),
        ("hazbot_gym.no_such:x", "'hazbot_gym.no_such'"),
        ("elsewhere:missing", "'missing'"),
        ("elsewhere:nothing", "has no predict"),
        ("elsewhere:Halves.missing", "'Halves.missing'"),
        ("constant:2", "fraction = '2' ... 1"),
        ("constant:fast", "fraction = 'fast'"),
        ("constant:speed=1", "'speed' ... fraction"),
        ("constant:0.5,0.6", "'0.6'"),
        ("constant:0.5,fraction=0.6", "'fraction'"),
        ("fuzzy_expert:rules=9", "rules = '9' ... 'complete32' or 'literal8'"),
        ("ttc:horizon_s=nan", "horizon_s = 'nan' ... finite number"),
        ("idm:nominal_mps=inf", "nominal_mps = 'inf' ... finite number"),
        ("mpc:horizon_s=1e9", "horizon_s = '1e9' ... 60"),
        ("mpc:nominal_mps=1e-9", "nominal_mps = '1e-9' ... 0.05"),
        *((f"velocity_obstacle:responsibility={share}", "responsibility") for share in (0, 1.5)),
        ("idm:lane_m=0", "lane_m"),
        ("hall_steps:scale=-1", "scale"),
        ("passive_safety:obstacle_mps=-1", "obstacle_mps"),
        ("stop_when_near:stop_m=-1", "stop_m"),
        ("stop_on_sight:stop_m=1.0,resume_m=0.5", "stop_m = 1.0"),
        ("mpc:horizon_s=0", "horizon_s"),
        ("fuzzy_reading:reading=upside_down", "reading ... 'upside_down'"),
        ("fuzzy_expert:release=perhaps", "release = 'perhaps'"),
    ],
)
def test_mistakes_are_one_line_that_says_what_is_allowed(spec: str, complaint: str) -> None:
    with refused(complaint):
        policies.make(spec)


def test_actions_run_from_stop_to_nominal_speed() -> None:
    actions = speed_action([0.0, 0.25, 1.0])

    assert actions.tolist() == [[-1.0], [-0.5], [1.0]]
    assert actions.dtype == np.float32
