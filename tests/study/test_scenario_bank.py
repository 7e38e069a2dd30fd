from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from hazbot_gym.bench import training
from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.study import bank_sets, scenario_bank
from hazbot_gym.study.bank_sets import BANK_SETS, GROUPS, BankSet
from hazbot_gym.study.config import load_study
from hazbot_gym.study.run import run_study
from hazbot_gym.study.store import EPISODES, read_episodes
from hazbot_gym.training import validation
from hazbot_gym.utils.yaml_loader import read_yaml
from tests.refusals import refused

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def written() -> pd.DataFrame:
    return scenario_bank.read()


def one(name: str) -> BankSet:
    return next(each for each in BANK_SETS if each.name == name)


def rows_of(written: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return the rows of a set's people, numbered from 0."""
    return written[written["scenario"].str.startswith(f"{name}/")].reset_index(drop=True)


@pytest.mark.parametrize("each", BANK_SETS, ids=lambda each: each.name)
def test_what_is_drawn_now_is_what_was_written_down(each: BankSet, written: pd.DataFrame) -> None:
    drawn = pd.DataFrame(scenario_bank.draw([each]))
    pd.testing.assert_frame_equal(drawn, rows_of(written, each.name), rtol=0.0, atol=2e-6)


def test_a_generator_that_changed_is_noticed(written: pd.DataFrame) -> None:
    changed = one("validation/Leading")._replace(
        overrides={"people": {"speeds": {"leader_low_mps": 0.16}}}
    )
    drawn = pd.DataFrame(scenario_bank.draw([changed]))
    with pytest.raises(AssertionError):
        pd.testing.assert_frame_equal(drawn, rows_of(written, changed.name), rtol=0.0, atol=2e-6)


def test_every_set_is_written_down_in_full_and_nothing_else_is(written: pd.DataFrame) -> None:
    names = written["scenario"].drop_duplicates().str.rpartition("/")[0]
    assert names.value_counts().to_dict() == {each.name: each.episodes for each in BANK_SETS}


def test_no_scenario_is_in_the_bank_twice(written: pd.DataFrame) -> None:
    scenarios = written.drop_duplicates("scenario")
    for column in ("seed", "scenario_key", "scenario_hash"):
        assert scenarios[column].is_unique, column


def test_its_seeds_have_a_root_that_nothing_else_has() -> None:
    configs = [read_yaml(path) for path in (ROOT / "configs").glob("*.yaml")]
    others = {validation.ROOT, training.ROOT, *(each.get("seed", 0) for each in configs)}
    assert bank_sets.ROOT not in others


def test_the_bank_is_small_enough_to_be_committed() -> None:
    assert scenario_bank.FILE.stat().st_size < 1.5e6


def test_a_study_names_a_split_a_group_or_a_set() -> None:
    assert [each.name for each in load_study(sets="bank:test/Crossing").sets] == ["test/Crossing"]
    faster = load_study(sets=["bank:ood/faster", "E*"]).sets
    assert [each.name for each in faster[:2]] == ["ood/faster/Crossing", "ood/faster/Encountering"]
    assert faster[-1].name == "E*"
    everything = load_study(sets=["bank:validation", "bank:test", "bank:ood", "bank:gas"]).sets
    assert [each.name for each in everything] == [each.name for each in BANK_SETS]


def test_a_set_is_run_as_far_as_it_goes() -> None:
    study = load_study(sets=["bank:test/Crossing", "bank:ood/dense", "E*"], episodes=120)
    assert [study.episodes_in(each) for each in study.sets] == [120, 60, 1]


def test_further_overrides_are_laid_over_those_of_the_bank() -> None:
    (dense,) = load_study(sets=[{"bank": "ood/dense", "overrides": {"tier": "sonar"}}]).sets
    config, _ = resolve(dense)
    assert config.tier == "sonar"
    assert config.people.count == (6, 10)


def test_beside_the_bank_the_moments_among_real_people_are_frozen_too(tmp_path: Path) -> None:
    def roots(sets: Any) -> set[int | None]:
        return {each.seed for each in load_study(sets=sets, tracks=tmp_path, seed=4).all_sets}

    assert roots(["bank:ood/dense"]) == {bank_sets.ROOT}
    assert roots(["E*"]) == {None}


@pytest.mark.parametrize(
    ("sets", "complaint"),
    [
        ("bank:tset", "sets ... 'bank:tset' ... bank:validation, bank:test"),
        ("bank:test/Cross", "sets ... 'bank:test/Cross'"),
        ("bank:", "sets ... 'bank:'"),
        ([{"bank": "test", "tier": "sonar"}], "sets ... {'bank': 'test', 'tier': 'sonar'}"),
        ([{"bank": "test", "overrides": 3}], "bank ... overrides"),
        (["bank:test", "bank:test/Crossing"], "'test/Crossing' twice"),
    ],
)
def test_a_name_that_is_none_is_refused_in_a_line(sets: Any, complaint: str) -> None:
    with refused(complaint):
        load_study(sets=sets)


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_a_study_meets_the_banks_scenarios_whatever_its_own_seed(
    engine: str, written: pd.DataFrame, tmp_path: Path
) -> None:
    study = load_study(
        policies=["constant:1.0"],
        sets=["bank:validation/Crossing"],
        episodes=3,
        resamples=100,
        seed=9,
        engine=engine,
    )
    run_study(study, tmp_path, workers=1)
    met = read_episodes(tmp_path / EPISODES)
    expected = rows_of(written, "validation/Crossing").drop_duplicates("scenario").head(3)
    assert met["scenario"].tolist() == [f"validation/Crossing/{i:03d}" for i in range(3)]
    assert met["scenario_hash"].tolist() == expected["scenario_hash"].tolist()
    assert met["scenario_key"].tolist() == expected["scenario_key"].astype(str).tolist()


def test_rows_of_other_scenarios_under_a_name_of_the_bank_are_refused(
    written: pd.DataFrame,
) -> None:
    rows = written.drop_duplicates("scenario").head(4)[["scenario", "scenario_hash"]]
    rows = pd.concat([rows, pd.DataFrame({"scenario": ["E*/000"], "scenario_hash": ["any"]})])
    scenario_bank.check(rows)
    rows["scenario_hash"] = rows["scenario_hash"].iloc[0]
    with refused("'validation/Corridor/001'"):
        scenario_bank.check(rows)


def test_the_page_lists_every_group_with_its_size_and_meaning() -> None:
    page = (ROOT / "docs" / "bank.md").read_text(encoding="utf-8")
    for name, group in GROUPS.items():
        assert f"| `bank:{name}` | {bank_sets.size(group)} | {group.meaning} |" in page
