from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from hazbot_gym.bench.cases import batched
from hazbot_gym.bench.run import CARTPOLE, CORRIDOR, QUICK, calls_for, measure, ratio


def test_record_has_every_case_with_median_spread_and_ratio(record: dict[str, Any]) -> None:
    for case in (record[CORRIDOR], record[CARTPOLE], *record["cases"].values()):
        low, high = case["steps_per_s_quartiles"]
        assert 0 < low <= case["steps_per_s"] <= high
        assert case["turns"] == 2
    assert record[CARTPOLE]["to_cartpole"] == 1.0
    assert record["cases"][batched(1024, 4)]["to_cartpole"] == pytest.approx(1024)
    assert record["ratio"] == record[CORRIDOR]["to_cartpole"]
    assert record["notes"] == ["SB3 adapter left out"]
    assert record["machine"]["cores"] >= 1
    assert json.loads(json.dumps(record)) == record


def test_goals_stand_beside_what_was_measured(record: dict[str, Any]) -> None:
    goals = record["goals"]
    assert goals[f"{batched(1024, 4)}, to {CARTPOLE}"]["at least"] == 9.0
    assert goals[f"{batched(1024, 4)}, to {CORRIDOR}"]["at least"] == 60.0
    assert goals["first episodes, cached, s"] == {"at most": 2.0, "measured": 1.25}
    assert goals["first episodes, compiling, s"] == {"at most": 40.0, "measured": 1.25}
    assert goals["policy ppo, 1024 observations, to batched, 1024 worlds, 4 people"] == {
        "at least": 1.0,
        "measured": pytest.approx(2.0),
    }
    # Every call takes as long, so that eight times the worlds are eight times the steps.
    assert goals["batched, 4 people, 8192 worlds to 1024"]["measured"] == pytest.approx(8)


def test_the_parts_of_a_step_are_what_cases_differ_by(record: dict[str, Any]) -> None:
    # A call takes 100 us: 1 us a world with everything, 0.5 without people, 0.2 without wheels.
    assert list(record["breakdown_us"].values()) == pytest.approx([0.5, 0.3, 0.2])


def test_a_turn_takes_about_its_time(timed: Callable[..., Any]) -> None:
    assert calls_for(timed(1), turn_s=0.01) == 100
    assert calls_for(timed(1), turn_s=1e-6) == 1


def test_turns_of_all_cases_are_interleaved(timed: Callable[..., Any]) -> None:
    order: list[str] = []
    cases = {name: timed(1, name, order) for name in ("a", "b")}
    rates = measure(cases, QUICK._replace(turns=3, turn_s=1e-3))
    assert order[-6:] == ["a", "b", "a", "b", "a", "b"]
    assert rates["b"] == pytest.approx([10_000.0] * 3)


def test_a_ratio_is_the_median_over_paired_turns() -> None:
    rates = {"a": [2.0, 40.0, 3.0], "b": [1.0, 10.0, 1.0]}
    assert ratio(rates, "a", "b") == 3.0
