"""A rule with a correction on top: by hand, from a file, and what a file may not name."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.policies.actor import Actor
from hazbot_gym.policies.actor_file import card, describe, read, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.residual import corrected
from tests.refusals import refused, says


def saved(folder: Path, bias: float, residual: dict[str, Any], weight: float = 0.0) -> Path:
    """Write a network of one layer that corrects a base on tracked people."""
    layer = Layer(np.full((51, 1), weight, np.float32), np.array([bias], np.float32))
    actor, path = Actor((layer,), "tanh", "clipped"), folder / "policy.npz"
    with path.open("wb") as file:
        write(describe(actor, algorithm="PPO", tier="tracks", residual=residual), file)
    return path


def test_a_correction_counts_by_its_scale_and_ends_at_stop_and_nominal_speed() -> None:
    base, correction = np.float32([[0.25], [0.9], [-0.9]]), np.float32([[-0.5], [1.0], [-1.0]])
    assert corrected(base, correction, 0.5).tolist() == [[0.0], [1.0], [-1.0]]


def test_a_file_is_its_base_and_its_network(tmp_path: Path, seen: Any) -> None:
    path = saved(tmp_path, 0.1, {"base": "fuzzy_expert:scale=0.8", "scale": 0.5}, weight=0.01)
    base, _ = policies.make("fuzzy_expert:scale=0.8").predict(seen())
    network = read(path).actor.act(seen())[0]
    action, _ = policies.make(f"learned:path={path}").predict(seen())
    assert action == pytest.approx(np.clip(base + 0.5 * network, -1.0, 1.0), abs=1e-6)
    assert np.ptp(network) > 0.01
    says(card(read(path), "mine").replace("\n", " "), "fuzzy_expert:scale=0.8 ... 0.5")


def test_a_network_that_says_nothing_is_its_base_with_its_inner_state(
    tmp_path: Path, seen: Any
) -> None:
    policy = policies.make(f"learned:{saved(tmp_path, 0.0, {'base': 'stop_on_sight', 'scale': 1})}")
    base, states, starts = policies.make("stop_on_sight"), [None, None], np.ones(500, np.bool_)
    for observation in (seen(), seen()[::-1]):
        (one, states[0]), (other, states[1]) = (
            each.predict(observation, state, starts)
            for each, state in zip((policy, base), states, strict=True)
        )
        assert np.array_equal(one, other)
        starts[:] = False
    assert len(np.unique(one)) > 1


def test_one_observation_is_answered_as_among_others(tmp_path: Path, seen: Any) -> None:
    path = saved(tmp_path, 0.1, {"base": "fuzzy_expert", "scale": 0.5}, weight=0.01)
    policy = policies.make(f"learned:{path}")
    many, _ = policy.predict(seen())
    assert np.array_equal(policy.predict(seen()[7])[0], many[7])


def test_it_needs_no_torch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path, 0.0, {"base": "fuzzy_expert", "scale": 0.5})
    for name in ("torch", "stable_baselines3", "sb3_contrib"):
        monkeypatch.setitem(sys.modules, name, None)
    policies.make(f"learned:{path}").predict(np.zeros(51, np.float32))


@pytest.mark.parametrize("base", ["nobody", "learned:other.zip,allow_pickle=true", "this:s"])
def test_a_base_that_would_run_what_a_file_says_is_refused(base: str, tmp_path: Path) -> None:
    path = saved(tmp_path, 0.0, {"base": base, "scale": 0.5})
    with refused("residual.base ... constant") as c:
        policies.make(f"learned:{path}")
    assert "learned" not in str(c.value).split("allowed are")[1]
    assert "this" not in sys.modules


@pytest.mark.parametrize(
    "residual", [{"base": "constant"}, {"base": 3, "scale": 0.5}, {"base": "constant", "scale": -1}]
)
def test_half_a_description_is_a_damaged_file(residual: dict[str, Any], tmp_path: Path) -> None:
    with refused("damaged"):
        read(saved(tmp_path, 0.0, residual))
