"""Tests of the Lagrange multiplier: its update, the penalized rewards, the effect on the policy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from hazbot_gym.training import run as training
from hazbot_gym.training.combined_envs import CombinedEnvs
from hazbot_gym.training.config import Lagrangian, TrainConfig, load_training
from hazbot_gym.training.ppo_lagrangian import MultiplierState, PenalizedEnvs, updated
from hazbot_gym.training.run import train
from hazbot_gym.training.validation import selection_key
from hazbot_gym.training.vec_envs import make_envs

LIVELY: dict[str, Any] = {"place": "doorway", "people": {"count": [2, 4]}, "max_episode_steps": 100}
RUN: dict[str, Any] = {
    "worlds": 16,
    "steps": 4096,
    "overrides": LIVELY,
    "options": {"n_steps": 32, "batch_size": 256, "n_epochs": 2},
    "network": {"net_arch": [16]},
    "validation": {"every_steps": 2048, "episodes": 8},
}


def run(limit: float, start: float, **changes: Any) -> TrainConfig:
    lagrangian = {"limit": limit, "start": start, "rate": 1.0}
    return load_training(None, **{**RUN, "lagrangian": lagrangian, **changes})


def test_the_multiplier_rises_with_the_excess_and_falls_to_nothing_below_the_limit() -> None:
    rule = Lagrangian(limit=2.0, rate=0.5)
    assert updated(MultiplierState(1.0, 1.0), 3.0, rule) == MultiplierState(1.5, 1.5, 3.0)
    assert updated(MultiplierState(1.0, 1.0), 1.0, rule) == MultiplierState(0.5, 0.5, 1.0)
    assert updated(MultiplierState(0.25, 0.25), 1.0, rule) == MultiplierState(0.0, 0.0, 1.0)


def test_as_a_controller_it_also_answers_the_excess_itself_and_growth_but_no_fall() -> None:
    rule = Lagrangian(limit=2.0, rate=0.5, proportional=4.0, derivative=8.0)
    grown = updated(MultiplierState(1.0, 1.0, 2.5), 3.0, rule)
    assert grown == MultiplierState(1.5 + 4.0 * 1.0 + 8.0 * 0.5, 1.5, 3.0)
    assert updated(grown, 2.5, rule) == MultiplierState(1.75 + 4.0 * 0.5, 1.75, 2.5)
    assert updated(MultiplierState(1.0, 1.0, math.inf), 3.0, rule).multiplier == 1.5 + 4.0


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_each_cost_is_charged_at_the_multiplier(engine: str) -> None:
    config = TrainConfig(worlds=4, overrides=LIVELY, engine=engine, reward_scale=0.1)  # type: ignore[arg-type]
    free, penalized = make_envs(config), PenalizedEnvs(make_envs(config), 3.0, 0.1)
    for envs in (free, penalized):
        envs.seed(2)
        envs.reset()
    charged = 0.0
    for _ in range(120):
        action = np.ones((4, 1), np.float32)
        (_, rewards, *_), (_, less, *_) = free.step(action), penalized.step(action)
        costs = cast(CombinedEnvs, free.unwrapped).costs
        assert less == pytest.approx(rewards - 0.1 * 3.0 * costs, abs=1e-5)
        charged += costs.sum()
    assert charged > 1.0


@pytest.mark.parametrize(("limit", "start", "is_rising"), [(0.0, 0.0, True), (1e3, 4.0, False)])
def test_a_run_finds_its_multiplier(
    limit: float, start: float, tmp_path: Path, *, is_rising: bool
) -> None:
    model: Any = train(run(limit, start), tmp_path / "run").model
    multiplier = MultiplierState(*model.multiplier)
    assert (multiplier.multiplier > 1.0) if is_rising else (multiplier.multiplier == 0.0)
    assert 0.0 < multiplier.cost < 100.0


def test_a_high_multiplier_makes_a_cheaper_policy(tmp_path: Path) -> None:
    learning = {"steps": 16_384, "learning_rate": 3e-3}
    validation = {"every_steps": 16_384, "episodes": 32}
    cheap, dear = (
        train(run(limit, start, **learning, validation=validation), tmp_path / name).best["cost"]
        for name, limit, start in (("free", 1e3, 0.0), ("dear", 0.0, 100.0))
    )
    assert dear < 0.7 * cheap  # type: ignore[operator]


def test_a_critic_that_is_taught_first_expects_to_pay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    multipliers: list[float] = []
    monkeypatch.setattr(
        training, "imitate", lambda _, envs, *__: multipliers.append(envs.multiplier)
    )
    train(run(1.0, 2.5, imitation={}, steps=512), tmp_path / "run")
    assert multipliers == [2.5]


def test_the_multiplier_is_shown(tmp_path: Path) -> None:
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    train(run(0.0, 0.0), tmp_path)
    curves = EventAccumulator(str(tmp_path / "tensorboard")).Reload()
    assert {"lagrangian/multiplier", "lagrangian/cost"} <= set(curves.Tags()["scalars"])


def test_who_keeps_the_limit_goes_before_who_earns_more() -> None:
    found = [{"cost": c, "return": r} for c, r in ((0.5, 1.0), (1.0, 2.0), (1.5, 9.0), (3.0, 8.0))]
    assert max(found, key=lambda each: selection_key(each, 1.0)) == found[1]
    assert max(found[2:], key=lambda each: selection_key(each, 1.0)) == found[2]
    assert max(found, key=lambda each: selection_key(each, None)) == found[2]
