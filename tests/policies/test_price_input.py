"""The price of nearness as the last input of a network, and its fold into the bias."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym import policies
from hazbot_gym.export.plan import plan_of
from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.actor_file import Trained, card, describe, read, write
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.price_input import PriceInput, at_price
from tests.refusals import refused

PRICES = PriceInput(1.0, 16.0, 4.0)


def network(width: int = 52) -> Actor:
    rng = np.random.default_rng(0)
    first = Layer(np.float32(rng.normal(size=(width, 8))), np.ones(8, np.float32))
    return Actor((first, Layer(np.full((8, 1), 0.02, np.float32), np.zeros(1, np.float32))), "tanh",
                 "clipped")  # fmt: skip


def saved(path: Path, *, has_price: bool = True) -> Path:
    actor = network() if has_price else network(51)
    prices = PRICES if has_price else None
    with path.open("wb") as file:
        write(describe(actor, algorithm="PPO", tier="tracks", prices=prices), file)
    return path


def test_the_entry_is_logarithmic_between_its_ends() -> None:
    entries = PRICES.entry(np.array([1.0, 2.0, 4.0, 8.0, 16.0]))
    assert entries == pytest.approx([-1.0, -0.5, 0.0, 0.5, 1.0])
    assert PRICES.price(entries) == pytest.approx([1.0, 2.0, 4.0, 8.0, 16.0])


@pytest.mark.parametrize("price", [1.0, 3.0, 16.0])
def test_a_folded_network_answers_like_the_one_with_the_input(price: float) -> None:
    seen = np.float32(np.random.default_rng(1).uniform(-1, 1, (30, 51)))
    entry = np.full((30, 1), PRICES.entry(price), np.float32)
    whole, _ = network().act(np.hstack([seen, entry]))
    folded = at_price(network(), PRICES, price)
    assert folded.width == 51
    assert folded.act(seen)[0] == pytest.approx(whole, abs=1e-6)


def test_an_export_is_a_plain_network_at_the_price(tmp_path: Path) -> None:
    plan = plan_of(f"learned:price=2,path={saved(tmp_path / 'policy.npz')}")
    assert plan.actor is not None
    assert plan.actor.width == 51
    assert np.array_equal(
        plan.actor.layers[0].bias, at_price(network(), PRICES, 2.0).layers[0].bias
    )


def test_the_price_is_an_option_of_the_policy(tmp_path: Path) -> None:
    path = saved(tmp_path / "a,b.npz")
    seen = np.zeros((1, 51), np.float32)
    found = [
        policies.make(f"learned:{option}{path}").predict(seen)[0].item()
        for option in ("", "path=", "price=4,", "price=4,path=", "price=1,path=")
    ]
    assert len(set(found[:4])) == 1
    assert found[4] != found[0]


@pytest.mark.parametrize(
    ("options", "has_price", "complaint"),
    [
        ("price=0.9,path={}", True, "price ... 0.9 ... 1 to 16"),
        ("price=17,path={}", True, "price ... 17 ... 1 to 16"),
        ("price=nan,path={}", True, "price ... nan"),
        ("price=cheap,path={}", True, "price ... 'cheap'"),
        ("path={},price=2", True, "price ... learned:price=P,path=FILE"),
        ("price=4,path={}", False, "price ... 4 ... no such input"),
        ("price=2,path=model.zip", False, "price ... 2 ... hazbot train"),
    ],
)
def test_no_price_is_guessed(options: str, has_price: bool, complaint: str, tmp_path: Path) -> None:
    path = saved(tmp_path / "policy.npz", has_price=has_price)
    with refused(complaint):
        policies.make(f"learned:{options.format(path)}")


def test_a_file_tells_its_prices_and_one_without_has_no_word_of_them(tmp_path: Path) -> None:
    about = read(saved(tmp_path / "priced.npz")).about
    assert about["prices"] == {"low": 1.0, "high": 16.0, "usual": 4.0}
    plain = read(saved(tmp_path / "plain.npz", has_price=False))
    assert "prices" not in plain.about
    assert "price=1` to `16` s/s, by default `4`" in card(read(tmp_path / "priced.npz"), "priced")


@pytest.mark.parametrize(
    "prices",
    [
        {"low": 16.0, "high": 1.0, "usual": 4.0},
        {"low": 1.0, "high": 16.0, "usual": 32.0},
        {"low": 0.0, "high": 16.0, "usual": 4.0},
        {"low": 1.0, "high": True, "usual": 1.0},
        {"low": 1.0},
        [1.0, 16.0],
    ],
)
def test_a_file_with_other_prices_than_a_range_is_damaged(prices: Any, tmp_path: Path) -> None:
    trained = read(saved(tmp_path / "policy.npz"))
    with (tmp_path / "policy.npz").open("wb") as file:
        write(Trained(trained.actor, {**trained.about, "prices": prices}), file)
    with refused("damaged"):
        read(tmp_path / "policy.npz")


def test_a_normalised_price_is_refused() -> None:
    rows = np.ones((2, 52), np.float32)
    actor = network()._replace(normalisation=Normalisation(*rows, 10.0, 1e-8))
    with refused("prices ... normalisation"):
        describe(actor, algorithm="PPO", tier="tracks", prices=PRICES)
