from __future__ import annotations

from typing import Any

import pytest

from hazbot_gym.evaluation.statistics.pareto import dominated, standing


def result(time: float, intrusion: float, half: float = 0.1) -> dict[str, Any]:
    axes = {"delay_s": time, "discomfort_s": intrusion}
    return {
        "metrics": {
            name: {"mean": mean, "low": mean - half, "high": mean + half}
            for name, mean in axes.items()
        }
    }


def test_better_on_both_axes_dominates() -> None:
    assert dominated({"good": result(1.0, 1.0), "bad": result(2.0, 2.0)}) == {
        "good": [],
        "bad": ["good"],
    }


@pytest.mark.parametrize("other", [result(0.5, 2.0), result(2.0, 0.5)])
def test_a_trade_dominates_nobody(other: dict[str, Any]) -> None:
    assert dominated({"one": result(1.0, 1.0), "other": other}) == {"one": [], "other": []}


@pytest.mark.parametrize("worse", [(1.15, 2.0), (2.0, 1.15), (1.2, 1.2)])
def test_intervals_that_overlap_or_touch_decide_nothing(worse: tuple[float, float]) -> None:
    assert dominated({"one": result(1.0, 1.0), "other": result(*worse)})["other"] == []


def test_everybody_who_dominates_is_named_in_order() -> None:
    policies = {"b": result(1.0, 1.0), "a": result(1.5, 1.5), "last": result(3.0, 3.0)}
    assert dominated(policies)["last"] == ["b", "a"]


def test_what_is_not_known_dominates_nobody_and_is_not_dominated() -> None:
    unknown = result(1.0, 1.0)
    unknown["metrics"]["delay_s"] = {"mean": None, "low": None, "high": None}
    policies = {"unknown": unknown, "good": result(0.1, 0.1, 0.01), "bad": result(9.0, 9.0)}
    assert dominated(policies) == {"unknown": [], "good": [], "bad": ["good"]}


def test_a_set_without_any_interval_says_nothing_of_dominance() -> None:
    policies = {"a": result(1.0, 1.0), "b": result(9.0, 9.0)}
    assert standing(policies) == {"a": [], "b": ["a"]}
    for each in policies.values():
        for estimate in each["metrics"].values():
            estimate |= {"low": None, "high": None}
    assert standing(policies) == {"a": None, "b": None}
