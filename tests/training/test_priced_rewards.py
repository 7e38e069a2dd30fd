"""A price of nearness for each episode: drawn, paid and observed; one network serves them all."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from hazbot_gym import policies
from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.policies.price_input import PriceInput
from hazbot_gym.task.reward import INTRUSION
from hazbot_gym.training.callbacks import export_best
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.priced_rewards import AtPrice, PricedRewards, price_input_of
from hazbot_gym.training.run import make_all, train
from hazbot_gym.training.validation import validate, validate_at_prices
from hazbot_gym.training.vec_envs import make_envs
from hazbot_gym.utils.files import write_json
from tests.refusals import refused

CROWD: dict[str, Any] = {"people": {"count": [6, 6]}}
RUN: dict[str, Any] = {
    "worlds": 4,
    "steps": 192,
    "prices": [1, 16],
    "asymmetric_critic": True,
    "overrides": {"max_episode_steps": 20},
    "options": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "network": {"net_arch": [4]},
    "validation": {"every_steps": 64, "episodes": 1},
}


def made(seed: int = 0, **changes: Any) -> Any:
    envs = make_envs(TrainConfig.model_validate({"worlds": 1, **changes}))
    envs.seed(seed)
    return envs


def priced(envs: Any) -> PricedRewards:
    while not isinstance(envs, PricedRewards):
        envs = envs.venv
    return envs


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("shaping", ["none", "free_drive"])
def test_rewards_are_those_of_an_environment_with_the_weight_of_the_price(
    seed: int, shaping: str
) -> None:
    envs = made(seed, prices=[1, 16], overrides=CROWD, shaping=shaping)
    envs.reset()
    weight = {"reward": {"intrusion": -0.1 * priced(envs).prices[0]}}
    others = made(seed, overrides={**CROWD, **weight}, shaping=shaping)
    others.reset()
    intruded = 0.0
    for _ in range(150):
        _, paid, _, _ = envs.step(np.ones((1, 1), np.float32))
        _, expected, ended, _ = others.step(np.ones((1, 1), np.float32))
        assert paid == pytest.approx(expected, abs=1e-6)
        intruded += envs.unwrapped.terms[0, INTRUSION]
        if ended[0]:
            break
    assert intruded > 0.1


def test_each_episode_has_its_price_and_observes_it() -> None:
    envs = made(worlds=6, prices=[1, 16], overrides={"max_episode_steps": 10})
    inputs = PriceInput(1.0, 16.0, 4.0)
    seen = envs.reset()
    first = priced(envs).prices.copy()
    assert len(set(first)) == 6
    assert seen.shape == (6, 52)
    for _ in range(10):
        assert inputs.price(seen[:, -1].astype(float)) == pytest.approx(first, rel=1e-5)
        seen, _, dones, infos = envs.step(-np.ones((6, 1), np.float32))
    assert dones.all()
    last = np.array([info["terminal_observation"][-1] for info in infos], float)
    assert inputs.price(last) == pytest.approx(first, rel=1e-5)
    assert not np.isin(priced(envs).prices, first).any()
    assert inputs.price(seen[:, -1].astype(float)) == pytest.approx(priced(envs).prices, rel=1e-5)


def test_prices_are_drawn_evenly_on_a_logarithmic_scale() -> None:
    envs = made(worlds=400, prices=[2, 8], overrides={"people": {"count": [0, 0]}})
    envs.reset()
    prices = priced(envs).prices
    assert prices.min() >= 2.0
    assert prices.max() <= 8.0
    assert np.mean(prices < 4.0) == pytest.approx(0.5, abs=0.1)


def test_prices_and_staggered_starts_are_drawn_apart() -> None:
    envs = made(worlds=200, prices=[1, 16], staggered_starts=True, overrides=CROWD)
    seen = envs.reset()
    phases = envs.unwrapped.advance * 0.1 / envs.unwrapped.times_free_s
    assert abs(np.corrcoef(phases, seen[:, -1])[0, 1]) < 0.3


def test_a_run_resumes_to_the_same_bits(tmp_path: Path) -> None:
    whole = train(TrainConfig(**RUN), tmp_path / "whole")
    with pytest.raises(KeyboardInterrupt):
        train(TrainConfig(**RUN), tmp_path / "killed", curriculum=_kills_at(128))
    resumed = train(
        TrainConfig(**RUN), tmp_path / "killed", resume=True, curriculum=lambda step, found: {}
    )
    assert _weights(whole).equal(_weights(resumed))


def _kills_at(last: int) -> Any:
    def overrides(step: int, found: object) -> dict[str, object]:
        if step >= last:
            raise KeyboardInterrupt
        return {}

    return overrides


def _weights(result: Any) -> torch.Tensor:
    return torch.cat([each.detach().flatten() for each in result.model.policy.parameters()])


def test_the_file_drives_at_any_price_as_the_model_does(tmp_path: Path) -> None:
    config = TrainConfig(**RUN)
    model, _ = make_all(config)
    write_json(tmp_path / "manifest.json", {"config": config.model_dump(mode="json")})
    export_best(model, config, tmp_path, {})  # type: ignore[arg-type]
    inputs = price_input_of(config)
    assert inputs is not None
    seen = np.float32(np.random.default_rng(0).uniform(0.0, 0.1, (20, 51)))
    answers = []
    for price in (1.0, 2.5, 4.0, 16.0):
        policy = policies.make(f"learned:price={price},path={tmp_path / 'policy.npz'}")
        asked = AtPrice(model, float(inputs.entry(price)))  # type: ignore[arg-type]
        found, _ = policy.predict(seen)
        assert found == pytest.approx(asked.predict(seen)[0], abs=1e-5)
        answers.append(found)
    usual, _ = policies.make(f"learned:{tmp_path / 'policy.npz'}").predict(seen)
    assert np.array_equal(usual, answers[2])
    assert not np.allclose(answers[0], answers[3], atol=1e-3)
    assert actor_of(model).width == 52


def test_a_validation_is_the_mean_over_prices_with_the_return_at_each() -> None:
    config = TrainConfig(**{**RUN, "overrides": CROWD, "validation": {"episodes": 3}})
    brisk, slow = (policies.make(f"constant:fraction={fraction}") for fraction in (1.0, 0.5))
    one, other = validate(brisk, config), validate(slow, config)
    assert one["discomfort_s"]
    found = validate_at_prices({1.0: brisk, 16.0: slow}, 4.0, config)
    assert found["delay_s"] == pytest.approx((one["delay_s"] + other["delay_s"]) / 2)
    returns = (
        one["return"] + 3.0 * one["discomfort_s"],
        other["return"] - 12.0 * other["discomfort_s"],
    )
    assert found["return"] == pytest.approx(sum(returns) / 2)
    both = {"env": ["Corridor-v1", "Crossing-v1"], "validation": {"episodes": 6}}
    found = validate_at_prices(
        {1.0: brisk, 16.0: slow}, 4.0, TrainConfig(**{**RUN, "overrides": CROWD, **both})
    )
    parts = found["return/Corridor-v1"], found["return/Crossing-v1"]
    assert found["return"] == pytest.approx(sum(parts) / 2)


def test_a_run_without_prices_is_the_run_it_was() -> None:
    plain = TrainConfig()
    text = json.dumps(
        plain.model_dump(mode="json", exclude={"prices", "curriculum"}), sort_keys=True
    )
    assert plain.identity() == hashlib.sha256(text.encode()).hexdigest()[:16]
    assert plain.identity() != TrainConfig(prices=(1.0, 16.0)).identity()
    assert made().reset().shape == (1, 51)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"prices": [4, 4]}, "prices ... [4.0, 4.0] ... low < high"),
        ({"prices": [0, 4]}, "prices.0 ... 0"),
        ({"algorithm": "sac"}, "prices ... 'sac' ... 'ppo'"),
        ({"lagrangian": {"limit": 1.0}}, "prices ... lagrangian"),
    ],
)
def test_what_does_not_go_together_is_refused(changes: dict[str, Any], complaint: str) -> None:
    with refused(complaint):
        load_training(None, **{"prices": [1, 16], **changes})


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"prices": [5, 16]}, "prices ... 5 to 16 ... 4"),
        (
            {"overrides": {"reward": {"intrusion": {"uniform": [-0.8, -0.4]}}}},
            "prices ... randomised reward.intrusion",
        ),
        ({"curriculum": [{"overrides": {"reward": {"intrusion": -0.8}}}]}, "curriculum ... prices"),
    ],
)
def test_environments_have_one_price_within_the_range(
    changes: dict[str, Any], complaint: str, tmp_path: Path
) -> None:
    with refused(complaint):
        train(TrainConfig(**{**RUN, **changes}), tmp_path / "run")
    assert not (tmp_path / "run").exists()
