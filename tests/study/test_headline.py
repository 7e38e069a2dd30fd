from __future__ import annotations

from pathlib import Path

from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study import headline
from hazbot_gym.study.bank_sets import FAMILIES
from hazbot_gym.study.config import StudyConfig, load_study
from hazbot_gym.study.headline import IN_DISTRIBUTION, POOLED, headline_sets, pooled_sets
from tests.refusals import refused

CONFIGS = Path(__file__).parents[2] / "configs"


def a_set(name: str, env: str = "Corridor", **overrides: object) -> ScenarioSet:
    return ScenarioSet(name=name, env=f"hazbot_gym/{env}-v1", overrides=overrides)


def test_quick_and_full_study_pool_the_same_environments() -> None:
    title, quick = headline_sets(load_study(CONFIGS / "study.yaml"))
    assert title == IN_DISTRIBUTION
    assert sorted(quick) == sorted(FAMILIES)
    for name in ("study_full.yaml", "study_bank.yaml"):
        study = load_study(CONFIGS / name)
        title, sets = headline_sets(study)
        assert title == "test"
        assert sets == [f"test/{each}" for each in FAMILIES]


def test_recorded_people_are_not_in_distribution(tmp_path: Path) -> None:
    study = StudyConfig(sets=["Corridor"], tracks=tmp_path)
    assert headline_sets(study) == ("Corridor", ["Corridor"])


def test_a_study_elsewhere_pools_all_its_sets() -> None:
    study = StudyConfig(sets=(a_set("a", scenario="E*"), a_set("b", people={"count": [9, 9]})))
    assert headline_sets(study) == (POOLED, ["a", "b"])
    assert pooled_sets(study) == {POOLED: ["a", "b"]}


def test_what_robots_see_changes_no_scenario() -> None:
    study = StudyConfig(sets=(a_set("a", tier="sonar"), a_set("b", scenario="E*")))
    assert headline_sets(study) == ("a", ["a"])


def test_a_set_cannot_have_the_name_of_several_together() -> None:
    for name, others in ((POOLED, ["E*"]), (IN_DISTRIBUTION, ["E*", "Crossing"])):
        study = StudyConfig(sets=[*others, a_set(name)])
        with refused(f"sets ... '{name}'"):
            pooled_sets(study)


def test_the_headline_counts_scenarios_not_training_seeds() -> None:
    policies = {"learner": {"episodes": 50, "training_seeds": 5}}
    summary = {"headline": {"name": "a", "sets": ["a"]}, "sets": {"a": policies}}
    assert headline.headline(summary).episodes == 10
