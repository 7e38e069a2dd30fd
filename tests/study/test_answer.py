from __future__ import annotations

from typing import Any

import pytest

from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study.answer import answer, learned, verdict
from hazbot_gym.study.config import StudyConfig
from tests.refusals import says

SETS = tuple(
    ScenarioSet(name=name, env="hazbot_gym/Doorway-v1") for name in ("easy", "hard", "odd")
)
STUDY = StudyConfig(policies=("fuzzy_expert", "ppo", "learned:path=a[/b].npz", "ttc"), sets=SETS)


def result(returns: float, gain: tuple[float, float, float], delay: float = 1.25) -> Any:
    means = {
        "return": returns,
        "delay_s": delay,
        "personal_m": 0.03,
        "contacts_per_km": 0.01,
    }
    return {
        "dominated_by": None,
        "metrics": {name: {"mean": value} for name, value in means.items()},
        "return_gain": dict(zip(("mean", "low", "high"), gain, strict=True)),
    }


def summary(study: StudyConfig = STUDY) -> dict[str, Any]:
    gains = {"easy": (2.0, 1.0, 3.0), "hard": (-2.0, -3.0, -1.0), "odd": (0.0, -1.0, 1.0)}
    gains["all sets"] = (0.5, -0.25, 1.5)
    others = {"fuzzy_expert": 100.0, "learned:path=a[/b].npz": 90.0, "ttc": 300.0}
    return {
        "confidence": 0.95,
        "headline": {"name": "all sets", "sets": list(gains)[:3]},
        "sets": {
            name: {other: result(value, (0.0, 0.0, 0.0), 1.5) for other, value in others.items()}
            | {"ppo": result(110.0, gain)}
            for name, gain in gains.items()
        },
    }


def test_the_answer_names_the_sets_where_a_learned_policy_is_better_and_worse() -> None:
    says(
        answer(summary(), STUDY),
        "2 learned ... ppo ... fuzzy_expert ... 1 of 3 ... (easy) ... 1 (hard) ... 1 ... all sets"
        " ... +0.50 (95% ... -0.25 to 1.50) ... 1.25 ... 1.50 s ... 0.03 ... 0.03 m"
        " ... 0.01 ... 0.01",
    )


def test_the_verdict_is_three_sentences() -> None:
    found = summary()
    for name, by in {"fuzzy_expert": ["ppo"], "ttc": [], "ppo": []}.items():
        found["sets"]["all sets"][name]["dominated_by"] = by
    where, figures, pareto = verdict(found, STUDY)
    says(where, "1 of 3 ... (easy) ... 1 (hard) ... 1")
    says(figures, "+0.50 (95% ... -0.25 to 1.50)")
    says(pareto, "Pareto ... ttc, ppo")


def test_where_few_policies_are_dominated_the_verdict_names_these() -> None:
    found = summary()
    for policy, result in found["sets"]["all sets"].items():
        result["dominated_by"] = ["ppo"] if policy == "ttc" else []
    says(verdict(found, STUDY)[-1], "Pareto ... all 4 ... but ttc")


def test_where_no_policy_is_known_to_be_optimal_the_verdict_names_none() -> None:
    assert not any("Pareto" in sentence for sentence in verdict(summary(), STUDY))


@pytest.mark.parametrize("policies", [("fuzzy_expert", "ttc"), ("ppo", "ttc")])
def test_without_a_learned_policy_beside_the_reference_the_answer_says_so(
    policies: tuple[str, ...],
) -> None:
    study = STUDY.model_copy(update={"policies": policies})

    says(answer(summary(study), study), f"No learned policy ... {policies[0]}")


def test_a_metric_that_is_nowhere_defined_is_left_out() -> None:
    found = summary()
    found["sets"]["all sets"]["ppo"]["metrics"]["delay_s"]["mean"] = None

    assert "the delay" not in answer(found, STUDY)


def test_a_single_scenario_makes_no_policy_better() -> None:
    found = summary()
    for block in found["sets"].values():
        block["ppo"]["return_gain"] |= {"low": None, "high": None}

    says(answer(found, STUDY), "0 of 3 ... 3 (3 ... single scenario) ... +0.50 (no interval")


def test_a_single_learned_policy_is_not_called_the_best_of_several() -> None:
    study = STUDY.model_copy(update={"policies": ("fuzzy_expert", "ppo")})

    assert "best of" not in answer(summary(study), study)


def test_shipped_policies_and_files_are_learned_and_rules_are_not() -> None:
    assert learned(STUDY) == ["ppo", "learned:path=a[/b].npz"]
