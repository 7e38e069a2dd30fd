from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.study.config import StudyConfig, load_study
from hazbot_gym.study.default_policies import MOST, default_policies, family_of

CONFIGS = Path(__file__).parents[2] / "configs"


def block(study: StudyConfig, returns: dict[str, float]) -> dict[str, Any]:
    """Return results in which the policies not named have a return of 0."""
    return {name: {"metrics": {"return": {"mean": returns.get(name, 0.0)}}} for name in study.names}


def test_reference_trained_rule_and_constants_are_shown_first() -> None:
    study = StudyConfig()
    returns = {"ttc": 3.0, "stop_on_sight": 2.0, "constant:0.5": 1.0, "constant:1.0": 9.0}
    assert default_policies(block(study, returns), study) == [
        "fuzzy_expert", "ppo", "ttc", "constant:1.0", "constant:0.5", "constant:0.25",
    ]  # fmt: skip


def test_the_reference_two_of_many_trained_policies_and_the_best_rule_are_shown_first() -> None:
    study = load_study(CONFIGS / "study_full.yaml")
    returns = {
        "ppo from nothing": 2.0,
        "qr-dqn": 3.0,
        "sac": 1.0,
        "dagger": 9.0,  # in the tables only
        "fuzzy_expert, tuned": 8.0,
        "velocity_obstacle, tuned": 2.5,
    }
    assert default_policies(block(study, returns), study) == [
        "fuzzy_expert",
        "qr-dqn",
        "ppo from nothing",
        "velocity_obstacle, tuned",
    ]


@pytest.mark.parametrize("name", ["study.yaml", "study_full.yaml"])
def test_few_policies_are_shown_by_default_and_all_of_them_in_plots(name: str) -> None:
    study = load_study(CONFIGS / name)
    found = default_policies(block(study, {}), study)
    assert found[0] == study.reference_policy
    assert len(set(found)) == len(found) <= MOST
    assert set(found) <= set(study.shown_names)


def test_tuned_policies_are_of_their_family() -> None:
    names = ["ssm, tuned", "ssm:mode=strict", "constant:0.5", "residual ppo on ssm"]
    assert [family_of(name) for name in names] == ["ssm", "ssm", "constant", "residual ppo on ssm"]
