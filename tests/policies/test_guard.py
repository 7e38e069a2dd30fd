"""Policies that cannot see stop: over the register, its options, files and memories."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.actor_file import describe, write
from hazbot_gym.policies.base import REGISTER
from hazbot_gym.policies.fuzzy_readings import READINGS
from hazbot_gym.policies.guard import Guarded
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from hazbot_gym.task.action import speed_action
from hazbot_gym.task.observation import LAYOUTS, layout_of
from tests.refusals import refused

RULES = (
    *(name for name in REGISTER if name not in ("learned", "shielded", "ppo_prices")),
    "shielded:policy=constant:1",
    "shielded:by=ssm,policy=shielded:policy=stop_on_sight",
    "constant:0.25",
    "ssm:mode=directional",
    "fuzzy_expert:rules=literal8,pattern=gaussian,t_norm=product",
    "fuzzy_expert:release=false,horizon_s=1",
    *(f"fuzzy_reading:reading={name}" for name in READINGS if name != "elapsed"),
)
ABOUT_GAS = ("slow_on_rise", "undo_lag")
NETWORKS = ("plain", "normalised", "levels", "memory", "residual", "residual memory")


def layer(rng: np.random.Generator, inputs: int, outputs: int) -> Layer:
    weight = rng.normal(size=(inputs, outputs)) / np.sqrt(inputs)
    return Layer(weight.astype(np.float32), np.zeros(outputs, np.float32))


def network(kind: str, width: int) -> Actor:
    """Return a network of random weights."""
    rng = np.random.default_rng(0)
    if "memory" in kind:
        gates = Lstm(layer(rng, width + 6, 24))
        return Actor((layer(rng, 6, 1),), "tanh", "clipped", lstm=gates)
    rows = np.full((2, width), 0.5, np.float32)
    statistics = Normalisation(*rows, 10.0, 1e-8) if kind == "normalised" else None
    outputs, head = (5, "levels") if kind == "levels" else (1, "squashed")
    layers = (layer(rng, width, 16), layer(rng, 16, outputs))
    return Actor(layers, "relu", head, statistics)


def made(kind: str, tier: str, folder: Path) -> policies.Policy:
    """Return a policy of the register, or one whose network is in a file."""
    if kind not in NETWORKS:
        return policies.make(kind)
    residual = {"base": "stop_on_sight", "scale": 0.5} if "residual" in kind else None
    actor = network(kind, LAYOUTS[tier].width)
    with (folder / "policy.npz").open("wb") as file:
        write(describe(actor, algorithm="PPO", tier=tier, residual=residual), file)
    return policies.make(f"learned:path={folder / 'policy.npz'}")


@pytest.fixture(params=["sonar", "tracks"])
def tier(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("kind", [*RULES, *NETWORKS])
def test_whoever_cannot_see_stops_and_the_rows_beside_drive_on(
    kind: str, tier: str, tmp_path: Path, seen: Any
) -> None:
    policy, good = made(kind, tier, tmp_path), seen(tier, has_gas=kind in ABOUT_GAS)
    width = good.shape[1]
    expected, _ = policy.predict(good[: 2 * width])
    layout = layout_of(good)
    for value in (np.nan, np.inf, -np.inf, layout.high + 0.01, layout.low - 0.01):
        bad = good[: 2 * width].copy()
        bad[np.arange(width), np.arange(width)] = value  # another entry in each row
        action, _ = policy.predict(bad)
        assert (action[:width] == -1.0).all()
        assert np.array_equal(action[width:], expected[width:])
        assert policy.predict(bad[0])[0].tolist() == [-1.0]


@pytest.mark.parametrize("kind", ["ttc", "stop_on_sight", "memory", "residual memory", "residual"])
def test_what_is_remembered_is_as_if_the_invalid_observation_had_not_been(
    kind: str, tier: str, tmp_path: Path, seen: Any
) -> None:
    policy, draws = made(kind, tier, tmp_path), seen(tier).reshape(50, 10, -1)[:12]
    for blind_at in ([0], [0, 1], [5], [5, 6], [0, 7, 11]):
        plain, broken = (_drive(policy, draws, drop) for drop in ((), blind_at))
        skipped = _drive(policy, np.delete(draws, blind_at, axis=0)[:, 3], ())
        assert np.array_equal(np.delete(plain, 3, axis=1), np.delete(broken, 3, axis=1))
        assert (broken[blind_at, 3] == -1.0).all()
        assert np.array_equal(np.delete(broken[:, 3], blind_at, axis=0), skipped)
    alone = _drive(policy, np.where(np.arange(12)[:, None] == 4, np.nan, draws[:, 3]), ())
    assert np.array_equal(np.delete(alone, 4, 0), _drive(policy, np.delete(draws[:, 3], 4, 0), ()))


def _drive(policy: policies.Policy, observations: Any, blind_at: Any) -> Any:
    """Return the actions of an episode; row 3 sees NaN in some decisions."""
    state, actions = None, []
    for k, row in enumerate(observations):
        now, starts = row.copy(), np.full(len(row) if row.ndim > 1 else 1, k == 0)
        if k in blind_at:
            now[3, 5] = np.nan
        action, state = policy.predict(now, state, starts)
        actions.append(action)
    return np.stack(actions)


def test_an_episode_that_begins_blind_forgets_the_one_before(tmp_path: Path, seen: Any) -> None:
    policy, (first, second, third) = (
        made("memory", "tracks", tmp_path),
        seen()[:6].reshape(3, 2, -1),
    )
    _, state = policy.predict(first)
    _, state = policy.predict(second * np.float32(np.nan), state, np.array([True, True]))
    action, _ = policy.predict(third, state, np.array([False, False]))

    assert np.array_equal(action, policy.predict(third)[0])


@pytest.mark.parametrize("kind", ["plain", "levels", "memory", "residual", "residual memory"])
@pytest.mark.parametrize("scale", [3e38, -3e38])
def test_a_network_whose_numbers_overflow_stops(
    kind: str, scale: float, tmp_path: Path, seen: Any
) -> None:
    policy = made(kind, "tracks", tmp_path)
    trained = getattr(policy._policy, "network", policy._policy)  # type: ignore[attr-defined]
    *others, (weight, bias) = trained.actor.layers
    head = Layer(np.full_like(weight, scale), np.full_like(bias, scale))
    trained.actor = trained.actor._replace(layers=(*others, head))
    ahead = np.abs(seen())

    action, _ = policy.predict(ahead)

    is_finite = np.isfinite(head.apply(_hidden(trained.actor, ahead))).all(axis=1)
    assert not is_finite.all()
    assert (action[~is_finite] == -1.0).all()


def _hidden(actor: Actor, observations: Any) -> Any:
    if actor.lstm:
        return actor.lstm.remember(observations, None).hidden
    return np.maximum(actor.layers[0].apply(observations), 0.0)


class Fragile(Guarded):
    """A policy of somebody else's that fails where its first entry is large."""

    def act(self, observation: Any, state: Any, starts: Any, deterministic: bool) -> Any:
        return speed_action(np.where(observation[..., 0] > 0.5, np.nan, 1.0)), state


def test_an_answer_that_is_no_number_is_a_stop_in_its_row_alone() -> None:
    observations = np.zeros((3, 51), np.float32)
    observations[1, 0] = 0.75

    action, state = Fragile().predict(observations, "kept")

    assert (action.tolist(), state) == ([[1.0], [-1.0], [1.0]], "kept")


def test_an_observation_of_another_width_need_only_be_finite() -> None:
    assert Fragile().predict(np.float32([-7.0, 9.0]))[0].tolist() == [1.0]
    assert Fragile().predict(np.float32([-7.0, np.nan]))[0].tolist() == [-1.0]


def test_rounding_beyond_the_bounds_is_no_failure() -> None:
    assert Fragile().predict(np.full(51, -1e-7, np.float32))[0].tolist() == [1.0]


@pytest.mark.parametrize("kind", [*RULES, *NETWORKS])
@pytest.mark.parametrize(
    "observation",
    [
        np.zeros(0),
        np.float32(1.0),
        None,
        "abc",
        {"a": 1},
        [[1.0], [1.0, 2.0]],
        np.zeros(51, complex),
    ],
    ids=["empty", "a number", "None", "text", "dict", "ragged", "complex"],
)
def test_an_observation_that_is_no_array_of_numbers_is_refused_in_a_line(
    kind: str, observation: Any, tmp_path: Path
) -> None:
    with refused("observation"):
        made(kind, "tracks", tmp_path).predict(observation)


@pytest.mark.parametrize("kind", [*RULES, *NETWORKS])
@pytest.mark.parametrize("starts", [True, [True] * 3, "xy", [2, 0], [np.nan, 0.0], ["a", ""], []])
def test_starts_that_do_not_fit_the_observations_are_refused_in_a_line(
    kind: str, starts: Any, tmp_path: Path
) -> None:
    with refused("episode_start ... booleans of shape (2,)"):
        made(kind, "tracks", tmp_path).predict(np.zeros((2, 51), np.float32), None, starts)


@pytest.mark.parametrize("kind", [*RULES, *NETWORKS])
def test_no_observations_are_answered_by_no_actions(kind: str, tmp_path: Path) -> None:
    action, _ = made(kind, "tracks", tmp_path).predict(np.zeros((0, 51), np.float32))
    assert (action.shape, action.dtype) == ((0, 1), np.float32)
