"""The page on every algorithm follows its record, whichever way the study comes out."""

from __future__ import annotations

from typing import Any

import pytest
from full_page import real_people
from full_record import REAL, ahead_of_best_rule
from full_summary import answer, readme_table, readme_text
from keep_search import kept

from tests.refusals import says

NAMES = ("fuzzy_expert", "idm, tuned", "ppo from nothing")


def estimate(mean: float, half: float = 0.5) -> dict[str, float]:
    return {"mean": mean, "low": mean - half, "high": mean + half}


def block(*returns: float) -> dict[str, Any]:
    """Return the results of the policies in a set, by their mean returns."""
    others = ("delay_s", "personal_m", "person_delay_s", "contacts_per_km", "arrived")
    return {
        name: {
            "episodes": 20 if name == "ppo from nothing" else 10,
            "training_seeds": 2 if name == "ppo from nothing" else 1,
            "metrics": dict.fromkeys(others, estimate(1.0)) | {"return": estimate(mean)},
            "return_gain": estimate(mean - returns[0]),
        }
        for name, mean in zip(NAMES, returns, strict=True)
    }


def record(learned: float, real: float) -> dict[str, Any]:
    """Return a record in which the learner has a return in the test, and another elsewhere."""
    test, recorded = block(300.0, 310.0, learned), block(300.0, 310.0, real)
    return {
        "headline": "test",
        "reference": "fuzzy_expert",
        "rules": list(NAMES[:2]),
        "best_rule": "idm, tuned",
        "over_best_rule": {
            name: estimate(found["metrics"]["return"]["mean"] - 310.0)
            for name, found in test.items()
        },
        "sets": {"test": test, "test/Crossing": test, **dict.fromkeys(REAL, recorded)},
        "runs": {"ppo from nothing": [{"return": learned}] * 2},
    }


@pytest.mark.parametrize(("learned", "ahead"), [(311.0, ["ppo from nothing"]), (310.2, [])])
def test_ahead_of_the_best_rule_is_who_has_an_interval_above_it(
    learned: float, ahead: list[str]
) -> None:
    found = record(learned, 300.0)
    assert ahead_of_best_rule(found) == ahead
    says(readme_text(found), f"(`idm, tuned`) ... {'`ppo from nothing`' if ahead else 'none'}.")


def test_the_best_rule_and_the_best_learned_policy_among_real_people_are_named() -> None:
    text = readme_text(record(320.0, 290.0))
    says(text, "as recorded `idm, tuned` (310.0) and `ppo from nothing` (290.0); reactive `idm")


def test_a_loss_among_real_people_is_told() -> None:
    text = real_people(record(320.0, 290.0))
    says(text, "as recorded, the best rule is `idm, tuned` (310.0) ... higher mean: none")
    says(text, "reactive ... clearly better are none, clearly worse `ppo from nothing`.")


def test_the_table_for_the_readme_has_real_people_beside_the_test_scenarios() -> None:
    table = readme_table(record(320.0, 290.0))
    best = table.splitlines()[2]
    assert (
        best == "| `ppo from nothing` | 320.0 | 1.0 | 1.00 | 1.0 | 1.00 | 100.0 | 290.0 | 290.0 |"
    )
    assert "10 test scenarios in 1 environments" in table


@pytest.mark.parametrize(
    ("learned", "compared", "ahead"),
    [(320.0, "earns more than", "`ppo from nothing`"), (305.0, "earns less than", "none")],
)
def test_the_answer_is_three_sentences_and_follows_the_intervals(
    learned: float, compared: str, ahead: str
) -> None:
    sonar = {"ppo": {"metrics": {"contact_robot_caused": estimate(0.02)}}}
    tracks = {"ppo": {"episodes": 10_800, "training_seeds": 1, "return_gain": estimate(2.0)}}
    study = {
        "shield": {"sets": {"sonar": sonar}},
        "many": {"reference": "mpc", "sets": {"tracks": tracks}},
    }
    sentences = answer(record(learned, 290.0), study).splitlines()
    assert [each[:3] for each in sentences] == ["1. ", "2. ", "3. "]
    says(sentences[0], "`ppo from nothing`, earns more than the fuzzy expert")
    says(sentences[1], f"it {compared} the best tuned rule, `idm, tuned` ... rule {ahead}.")
    says(sentences[1], "In 10,800 further scenarios, the shipped `ppo` earns more than `mpc`")
    says(sentences[2], "`idm, tuned` (310.0) ... `ppo from nothing` (290.0) ... in 2.0 % of the")


def test_searches_count_as_many_trials_as_the_shortest_has() -> None:
    long = {"trials": [{"return": 1.0}, {"return": 2.0}, {"return": 9.0}], "best": 2}
    short = {"trials": [{"return": 3.0}, {"return": 2.0}], "best": 0}
    found = kept({"long": long, "short": short})
    assert [len(search["trials"]) for search in found.values()] == [2, 2]
    assert [search["best"] for search in found.values()] == [1, 0]
