from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.evaluation import rollout
from hazbot_gym.evaluation.metrics import means
from hazbot_gym.policies import base
from hazbot_gym.policies.sweeps import SWEEPS
from hazbot_gym.policies.tuning_spaces import SPACES, Interval
from hazbot_gym.study import bank_sets, tuning
from hazbot_gym.study.tuning import VALIDATION, Search, tune
from hazbot_gym.utils.files import read_json
from tests.refusals import refused


@pytest.fixture
def hill(monkeypatch: pytest.MonkeyPatch) -> None:
    """Judge policies by how near their option is to 0.7, without running anything."""

    def judge(policy: str, *_: Any) -> dict[str, Any]:
        value = float(policy.partition("fraction=")[2])
        return {"return": -((value - 0.7) ** 2)}

    monkeypatch.setattr(tuning, "judge", judge)


@pytest.mark.parametrize("family", SPACES)
def test_every_default_lies_inside_its_bounds(family: str) -> None:
    for name, value in tuning.defaults(family).items():
        bounds = SPACES[family][name]
        if isinstance(bounds, Interval):
            assert bounds.low <= value <= bounds.high
        else:
            assert value in bounds


@pytest.mark.parametrize("family", SPACES)
def test_whatever_may_be_tuned_makes_a_policy(family: str) -> None:
    base.make(base.spec_of(family, tuning.defaults(family)))
    for end in (0, -1):
        base.make(base.spec_of(family, {name: each[end] for name, each in SPACES[family].items()}))


def test_every_family_with_a_knob_can_be_tuned_by_it() -> None:
    for family, sweep in SWEEPS.items():
        assert sweep.option in SPACES[family]


def test_a_search_finds_the_top_of_a_hill(tmp_path: Path, hill: None) -> None:
    record = tune(Search("constant", trials=30), tmp_path / "constant.json")
    assert record["best"]["options"]["fraction"] == pytest.approx(0.7, abs=0.05)
    assert record["trials"][0]["policy"] == "constant:fraction=1.0"  # as it comes
    assert record["at_a_bound"] == []


def test_a_best_value_at_a_bound_is_told(
    tmp_path: Path, hill: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SPACES, "constant", {"fraction": Interval(0.05, 0.5)})
    monkeypatch.setattr(tuning, "defaults", lambda family: {"fraction": 0.5})
    record = tune(Search("constant", trials=5), tmp_path / "constant.json")
    assert record["at_a_bound"] == ["fraction"]


def test_a_killed_search_goes_on_as_if_it_had_not_been(
    tmp_path: Path, hill: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, cut = tmp_path / "whole.json", tmp_path / "cut.json"
    tune(Search("constant", trials=20), whole)

    def stop() -> None:
        if len(read_json(cut)["trials"]) == 7:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tune(Search("constant", trials=20), cut, on_progress=stop)
    tune(Search("constant", trials=20), cut)
    assert cut.read_bytes() == whole.read_bytes()


def test_another_search_s_file_is_left_alone(tmp_path: Path, hill: None) -> None:
    path = tmp_path / "constant.json"
    tune(Search("constant", trials=2), path)
    before = path.read_bytes()
    with refused("another search"):
        tune(Search("constant", trials=2, seed=1), path)
    assert path.read_bytes() == before
    with refused("constant"):
        tune(Search("telepathy"), path)


def test_policies_are_judged_on_the_bank_s_validation_scenarios(tmp_path: Path) -> None:
    assert [each.name for each in VALIDATION] == [
        f"validation/{each}" for each in bank_sets.FAMILIES
    ]
    search = Search("constant", trials=1, episodes=2, sets=VALIDATION[:1])
    record = tune(search, tmp_path / "c.json")
    shard = rollout.Shard("constant:fraction=1.0", VALIDATION[0], 0, 2, bank_sets.ROOT)
    assert record["best"]["return"] == means(rollout.run_shard(shard))["return"]


def test_a_search_runs_no_scenario_that_is_not_in_the_bank(monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[int] = []

    def run(shard: rollout.Shard, threads: int) -> list[Any]:
        ran.append(shard.episodes)
        return []

    monkeypatch.setattr(rollout, "run_shard", run)
    tuning.judge("constant", Search("constant", episodes=10**6))
    assert ran == [each.episodes for each in VALIDATION]
