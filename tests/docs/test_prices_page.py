"""The record of one policy at five prices: the front is monotone."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from hazbot_gym.policies.actor_file import read
from hazbot_gym.policies.learned import SHIPPED
from hazbot_gym.utils.files import read_json

RECORD = read_json(Path(__file__).parents[2] / "benchmarks" / "prices.json")


def test_the_higher_the_price_the_less_discomfort_and_the_more_delay() -> None:
    for cheap, dear in pairwise(RECORD["prices"]):
        assert dear["price"] > cheap["price"]
        assert dear["discomfort_s"] < cheap["discomfort_s"]
        assert dear["delay_s"] > cheap["delay_s"]


def test_at_each_price_the_network_earns_most_when_told_that_price() -> None:
    for own in RECORD["prices"]:
        at = f"{own['price']:g}"
        assert own["returns"][at] >= max(each["returns"][at] for each in RECORD["prices"]) - 0.5


def test_the_record_is_that_of_the_shipped_policy() -> None:
    trained = read(SHIPPED / "prices_tracks.npz").about["training"]["config"]
    assert RECORD["environments"] == trained["env"]
    assert {trained[name] for name in RECORD["training"]} == set(RECORD["training"].values())
