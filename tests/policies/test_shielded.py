"""Shield: never faster than the policy or the rule, and no contact that the robot causes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.config import Config
from hazbot_gym.evaluation import batch_rollout, inputs
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.policies.residual import base_of
from tests.refusals import refused

SHIPPED_FILE = next(iter(sorted(SHIPPED.glob("ppo_*tracks*.npz"))))


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize("inner", ["fuzzy_expert", "ppo", "constant:1"])
def test_the_slower_action_counts(inner: str, tier: str, seen: Any) -> None:
    rows, rule = seen(tier), "ssm:mode=directional"
    alone, permitted = (policies.make(spec).predict(rows)[0] for spec in (inner, rule))
    action, _ = policies.make(f"shielded:by={rule},policy={inner}").predict(rows)
    assert (action == np.minimum(alone, permitted)).all()


def test_both_memories_are_kept(seen: Any) -> None:
    rows = seen("sonar")[:40].reshape(4, 10, -1)  # the rule and the expert remember echoes
    shield = policies.make("shielded:policy=fuzzy_expert")
    parts = [policies.make(spec) for spec in ("fuzzy_expert", "passive_safety:obstacle_mps=1.6")]
    state: Any = None
    states: list[Any] = [None, None]
    for row in rows:
        actions = []
        for k, part in enumerate(parts):
            action, states[k] = part.predict(row, states[k])
            actions.append(action)
        found, state = shield.predict(row, state)
        assert (found == np.minimum(*actions)).all()


def test_full_speed_behind_a_shield_causes_no_contact() -> None:
    config = Config(place="corridor", people={"count": [3, 3]}, tier="privileged")
    causes = {}
    for spec in ("constant:1", "shielded:policy=constant:1"):
        runs = batch_rollout.run_episodes(
            config, policies.make(spec), range(40), limit=600, threads=1
        )
        causes[spec] = sum(episode.contact_caused_by == "robot" for episode, _ in runs)
    assert causes["constant:1"] > 5
    assert causes["shielded:policy=constant:1"] == 0


def test_the_file_of_the_policy_is_an_input() -> None:
    spec = f"shielded:policy=learned:path={SHIPPED_FILE}"
    assert inputs.of_policy(spec, []) == [SHIPPED_FILE]


def test_nothing_runs_that_was_not_allowed(tmp_path: Path) -> None:
    with refused("policy: 'os:getcwd' ... run the code of 'os'"):
        policies.make("shielded:policy=os:getcwd", allow_code=False)
    with refused("reading ... runs code"):
        policies.make(f"shielded:policy=learned:path={tmp_path / 'a.zip'}")
    with refused("residual.base: given 'shielded:policy=os:getcwd'"):
        base_of("shielded:policy=os:getcwd")


def test_what_is_no_shield_is_refused() -> None:
    with refused("names no policy ... shielded:policy=SPEC"):
        policies.make("shielded:by=ssm")
    with refused("by: given 'constant' ... rules about people"):
        policies.make("shielded:by=constant,policy=ppo")
    with refused("'margin_m' is not known ... by"):
        policies.make("shielded:margin_m=1,policy=ppo")
    with refused("policy: 'nobody' is not known"):
        policies.make("shielded:policy=nobody")
