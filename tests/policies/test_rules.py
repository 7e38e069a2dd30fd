"""Properties that all rules about people share."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from hazbot_gym.policies import make

Maker = Callable[..., Any]
# The largest speed that any person permits, and rules that weigh people together.
STRICTEST = (
    *("fuzzy_expert", "fuzzy_expert:rules=literal8,pattern=gaussian", "stop_when_near"),
    *("ssm", "ssm:mode=directional", "ttc", "idm", "hall_steps", "passive_safety"),
    "velocity_obstacle",
)
RULES = (*STRICTEST, "constant:0.25", "stop_on_sight", "social_force:strength=4", "mpc")


@pytest.mark.parametrize("tier", ["sonar", "tracks"])
@pytest.mark.parametrize("spec", RULES)
def test_stacked_observations_get_the_actions_of_each(spec: str, tier: str, seen: Maker) -> None:
    policy, rows = make(spec), seen(tier)[:60]
    actions, _ = policy.predict(rows)
    assert (actions.shape, actions.dtype) == ((60, 1), np.float32)
    np.testing.assert_allclose(actions, [policy.predict(row)[0] for row in rows], atol=1e-6)
    restored = pickle.loads(pickle.dumps(policy))
    assert restored == policy
    assert np.array_equal(restored.predict(rows)[0], actions)


@pytest.mark.parametrize("spec", RULES)
def test_alone_a_rule_drives_at_its_nominal_speed(spec: str, observe: Maker, share: Maker) -> None:
    nominal = 0.25 if spec == "constant:0.25" else 1.0
    assert share(make(spec), observe(v=0.5, command=0.5)) == nominal


@pytest.mark.parametrize("spec", STRICTEST)
def test_the_strictest_of_several_people_counts(spec: str, observe: Maker, share: Maker) -> None:
    rng, policy, slower = np.random.default_rng(0), make(spec), 0
    for _ in range(100):
        pair = rng.uniform([-1.0, -2.0, -1.5, -1.0], [3.5, 2.0, 0.5, 1.0], (2, 4))
        one, other = (share(policy, observe(person, v=0.3, command=0.3)) for person in pair)
        both = share(policy, observe(*pair, v=0.3, command=0.3))
        assert both <= min(one, other) + 1e-6
        slower += one != other
    assert slower > 10
