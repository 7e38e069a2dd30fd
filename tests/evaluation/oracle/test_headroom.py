from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app
from hazbot_gym.config import make_config
from hazbot_gym.evaluation.oracle import headroom
from hazbot_gym.evaluation.oracle.headroom import Scenarios
from hazbot_gym.evaluation.oracle.headroom_report import (
    has_room,
    rule_rows,
    survey_rows,
    unit_rows,
)
from hazbot_gym.evaluation.oracle.trajectory_search import Effort
from hazbot_gym.policies.sweeps import SWEEPS, sweep
from hazbot_gym.utils.files import read_json
from tests.refusals import refused, says

RECORDS = Path(__file__).parents[3] / "benchmarks"
SHORT: dict[str, Any] = {"place_options": {"length_m": 5.0}, "max_episode_steps": 250}
EFFORT = Effort(worlds=8, rounds=4)


def short(name: str, *, is_scripted: bool, episodes: int) -> Scenarios:
    config = headroom.headroom_config(name, SHORT, is_scripted=is_scripted)
    return Scenarios(config, list(range(episodes)))


@pytest.mark.parametrize("name", ["Crossing-v1", "Leading-v1"])
def test_the_exact_optimum_bounds_every_policy(name: str) -> None:
    scenarios = short(name, is_scripted=True, episodes=3)
    start = headroom.play(scenarios, headroom.FULL_SPEED)
    best = np.array([each.value for each in headroom.best_drives(scenarios, [start], EFFORT)])
    specs = [spec for family in ("constant", *headroom.RULES) for spec in sweep(family)[::6]]
    for spec in specs:
        played = headroom.play(scenarios, spec)
        assert played.keys == start.keys
        assert np.all(played.returns <= best + 1e-6), spec


def test_the_search_ends_no_lower_than_any_policy_it_starts_from() -> None:
    scenarios = short("Crossing-v1", is_scripted=False, episodes=2)
    starts = [headroom.play(scenarios, spec) for spec in ("fuzzy_expert", "ttc", "constant:0.5")]
    found = headroom.best_drives(scenarios, starts, EFFORT)
    for k, each in enumerate(found):
        assert max(start.returns[k] for start in starts) - 1e-9 <= each.halfway <= each.value


def test_commands_are_rounded_to_the_lattice() -> None:
    policy = headroom.OnLattice(headroom.make("constant:0.33"))
    actions, _ = policy.predict(np.zeros((2, 51), np.float32))
    np.testing.assert_allclose(actions, 2.0 * 0.3 - 1.0, atol=1e-6)


def test_every_family_of_rules_is_compared() -> None:
    families = {family.partition(":")[0] for family in headroom.RULES}
    about_gas = {"slow_on_rise", "undo_lag"}
    assert families == set(SWEEPS) - about_gas - {"constant", "stop_when_near"}  # the zero


def test_five_or_more_environments_have_room() -> None:
    record = read_json(RECORDS / "headroom.json")
    assert set(record["environments"]) == set(headroom.environments())
    assert sum(has_room(found) for found in record["environments"].values()) >= 5
    assert record["episodes"] >= 100


def test_environments_with_gas_have_room() -> None:
    record = read_json(RECORDS / "headroom_gas.json")
    assert set(record["environments"]) == set(headroom.environments(has_gas=True))
    for found in record["environments"].values():
        assert has_room(found)
        assert found["expert"]["share"] < headroom.GAS_EXPERT_AT_MOST < headroom.EXPERT_AT_MOST
        found_leaks = [row["leak_found"] for row in found["constants"]]
        assert found_leaks == sorted(found_leaks)  # the slower, the more
    assert record["episodes"] >= 100
    rows = len(headroom.GAS_RULES) + len(headroom.CONSTANTS) + 3
    assert len(survey_rows(record)) == rows * len(record["environments"])


def test_environments_with_and_without_gas_are_not_compared_at_once() -> None:
    assert headroom.has_gas(["Inspection-v1", "InspectionEmpty-v1"])
    assert not headroom.has_gas(["Corridor-v1"])
    with refused("env ... Inspection-v1 ... without"):
        headroom.has_gas(["Corridor-v1", "Inspection-v1"])


@pytest.mark.parametrize(
    ("name", "families"), [("headroom", headroom.RULES), ("headroom_gas", headroom.GAS_RULES)]
)
def test_the_record_is_consistent(name: str, families: tuple[str, ...]) -> None:
    record = read_json(RECORDS / f"{name}.json")
    assert len(rule_rows(record)) == len(families) * len(record["environments"])
    assert len(unit_rows(record)) == 4 * len(record["environments"])
    for found in record["environments"].values():
        assert found["best"]["return"] == pytest.approx(found["best"]["bound"], abs=0.05)
        for row in (found["expert"], *found["rules"].values()):
            assert row["return"] <= found["best"]["bound"]
            assert row["interval"][0] <= row["share"] <= row["interval"][1]


def test_an_unknown_environment_is_one_line() -> None:
    result = CliRunner().invoke(app, ["headroom", "--env", "Replay-v1"])
    assert result.exit_code == 2
    says(result.output, "'Replay-v1' ... Corridor-v1")


def test_intervals_hold_the_shares() -> None:
    rng = np.random.default_rng(0)
    low, top = rng.normal(200.0, 5.0, 60), rng.normal(260.0, 5.0, 60)
    returns = 0.5 * (low + top) + rng.normal(0.0, 5.0, 60)
    lower, upper = headroom.interval(returns, low, top)
    assert lower < 0.5 < upper
    assert upper - lower < 0.1
    assert headroom.interval(low, low, top) == [0.0, 0.0]


def test_speeds_are_shares_of_decisions() -> None:
    plans = [np.array([-1.0, -0.8]), np.array([-0.6, 0.0, 0.8, 1.0])]
    assert headroom.speed_shares(plans) == pytest.approx([2 / 6, 1 / 6, 1 / 6, 0.0, 2 / 6])


@pytest.mark.slow
def test_overrides_change_the_environments_and_are_recorded(tmp_path: Path) -> None:
    file = tmp_path / "room.json"
    words = ["--env", "Crossing-v1", "--episodes", "2", "--tuning", "1", "--rounds", "2"]
    changes = ["--rule", "ttc", "--set", "max_episode_steps=250", "--json", str(file)]
    done = CliRunner().invoke(app, ["headroom", *words, *changes])
    assert done.exit_code == 0, done.output
    record = read_json(file)
    assert record["overrides"] == {"max_episode_steps": 250}
    found = record["environments"]["Crossing-v1"]
    assert sum(found["speeds"]) == pytest.approx(1.0)
    assert found["best"]["return"] >= found["expert"]["return"]


def test_contradicting_overrides_are_refused() -> None:
    words = ["--scripted", "--set", "people.model=social_force", "--episodes", "1"]
    refused = CliRunner().invoke(app, ["headroom", *words])
    assert refused.exit_code == 2
    says(refused.output, "people.model ... social_force ... scripted")


def test_the_config_is_the_registered_one() -> None:
    assert headroom.headroom_config("Corridor-v1") == make_config()
