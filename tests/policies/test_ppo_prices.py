"""The shipped policy for every price of nearness."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.policies.actor_file import card, prices_of, read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.training.config import TrainConfig, load_training
from tests.refusals import refused

FILE = SHIPPED / "prices_tracks.npz"
CONFIG = Path(__file__).parents[2] / "configs" / "ppo_prices.yaml"


def test_it_is_small_and_comes_again_by_its_config() -> None:
    assert FILE.stat().st_size < 200_000
    about = read(FILE).about
    config = load_training(CONFIG, seed=about["training"]["seed"])
    assert TrainConfig.model_validate(about["training"]["config"]) == config
    prices = prices_of(about)
    assert prices is not None
    assert config.prices == (prices.low, prices.high)
    assert FILE.with_suffix(".md").read_text(encoding="utf-8") == card(read(FILE), FILE.stem)


@pytest.mark.parametrize("price", [0.5, 17])
def test_no_other_price_than_those_of_its_training_is_taken(price: float) -> None:
    with refused(f"price ... {price:g} ... 1 to 16"):
        policies.make(f"ppo_prices:price={price}")


def test_people_must_be_tracked() -> None:
    with refused("tier ... 12 ... tracks"):
        policies.make("ppo_prices").predict(np.zeros(12, np.float32))


def test_a_higher_price_keeps_farther_away() -> None:
    near, far = (
        means(evaluate(f"ppo_prices:price={price}", "Circle-v1", episodes=10, seed=9))
        for price in (1, 16)
    )
    assert near["arrived"] == far["arrived"] == 1.0
    assert far["discomfort_s"] < 0.7 * near["discomfort_s"]
    assert far["delay_s"] > near["delay_s"]
