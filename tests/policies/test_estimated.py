"""A network for tracked people on sonar: by hand, from a file, through episodes, alone or not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import card, describe, read, write
from hazbot_gym.policies.estimated import Estimated
from hazbot_gym.policies.layer import Layer
from hazbot_gym.task.observation import LAYOUTS, NOBODY

TRACKS = LAYOUTS["tracks"]


def saved(folder: Path, residual: dict[str, Any] | None = None) -> Path:
    """Write a network of one layer that answers with the distance of the nearest person."""
    weight = np.zeros((TRACKS.width, 1), np.float32)
    weight[TRACKS.names.index("person0_distance_m")] = 1.0
    actor = Actor((Layer(weight, np.zeros(1, np.float32)),), "tanh", "clipped")
    with (folder / "policy.npz").open("wb") as file:
        write(
            describe(actor, algorithm="PPO", tier="sonar", estimated=True, residual=residual), file
        )
    return folder / "policy.npz"


def test_a_file_sees_who_is_betrayed_and_nobody_far_away(tmp_path: Path, seen: Any) -> None:
    policy = policies.make(f"learned:{saved(tmp_path)}")
    observation = np.ones((2, 12), np.float32)
    observation[:, 4:] = 0.0
    observation[1, :2] = 0.125  # half a metre, in both cones in front
    actions, _ = policy.predict(observation)
    assert actions[0, 0] == NOBODY[1] == 1.0
    assert actions[1, 0] == pytest.approx((0.5 + 0.5) / 8.0, abs=0.05)
    assert "with the people that `sonar_estimate` finds: 48 entries" in card(
        read(tmp_path / "policy.npz"), "mine"
    )


def test_what_is_remembered_is_each_episode_s_own(tmp_path: Path, seen: Any) -> None:
    policy = policies.make(f"learned:{saved(tmp_path, {'base': 'ssm', 'scale': 0.5})}")
    rng = np.random.default_rng(0)
    together, alone, starts = None, None, np.ones(500, np.bool_)
    for _ in range(10):
        observations = rng.permutation(seen("sonar"))
        actions, together = policy.predict(observations, together, starts)
        one, alone = policy.predict(observations[7], alone, starts[7])
        assert np.array_equal(one, actions[7])
        starts = rng.random(500) < 0.2


def test_a_rule_on_estimates_is_the_rule_on_sonar(seen: Any) -> None:
    rule = policies.make("ssm:mode=strict")
    state, own, starts = None, None, np.ones(500, np.bool_)
    for _ in range(5):
        expected, own = rule.predict(seen("sonar"), own, starts)
        actions, state = Estimated(rule).predict(seen("sonar"), state, starts)
        assert np.array_equal(actions, expected)
        starts[:] = False


def test_tracked_people_are_refused_in_one_line(tmp_path: Path) -> None:
    policy = policies.make(f"learned:{saved(tmp_path)}")
    with pytest.raises(
        InvalidInput, match="^tier: given observations of 48 entries, .* sonar with"
    ):
        policy.predict(np.zeros(48, np.float32))
