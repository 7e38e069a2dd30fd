"""The record of one policy at five prices: the front is monotone."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import pytest

from hazbot_gym.policies.actor_file import read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.utils.files import read_json

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))

from prices_page import exchange_rates  # noqa: E402

RECORD = read_json(ROOT / "benchmarks" / "prices.json")


def test_the_higher_the_price_the_less_discomfort_and_the_more_delay() -> None:
    for cheap, dear in pairwise(RECORD["prices"]):
        assert dear["price"] > cheap["price"]
        assert dear["discomfort_s"] < cheap["discomfort_s"]
        assert dear["delay_s"] > cheap["delay_s"]


def test_at_each_price_the_network_earns_more_than_every_rule() -> None:
    rules = [point for points in RECORD["rules"].values() for point in points]
    for own in RECORD["prices"]:
        at = f"{own['price']:g}"
        assert own["returns"][at] > max(rule["returns"][at] for rule in rules)


def test_exchange_rates_are_those_between_neighbours() -> None:
    first, second = RECORD["prices"][:2]
    (rate, *others) = exchange_rates(RECORD)
    gained = first["discomfort_s"] - second["discomfort_s"]
    assert rate * gained == pytest.approx(second["delay_s"] - first["delay_s"])
    assert len(others) == len(RECORD["prices"]) - 2


def test_the_record_is_that_of_the_shipped_policy() -> None:
    trained = read(SHIPPED / "prices_tracks.npz").about["training"]["config"]
    assert RECORD["environments"] == trained["env"]
    assert {trained[name] for name in RECORD["training"]} == set(RECORD["training"].values())
