from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.study.config import load_study
from hazbot_gym.study.policies_report import page, record_of
from hazbot_gym.study.summary import COMPARED, summarise

TEMPLATE = (Path(__file__).parents[2] / "docs" / "policies.template.md").read_text(encoding="utf-8")


def summary(*, ppo_ratio: float, ppo_intrusion: float) -> dict[str, Any]:
    """Return the summary of a study in which the expert stands at 1.5 and 0.1."""
    study = load_study(policies=["fuzzy_expert", "ppo"], sets=["Crossing", "Corridor"], episodes=20)
    noise = np.random.default_rng(0).normal(0.0, 0.01, 20)
    made = (("fuzzy_expert", 1.5, 0.1), ("ppo", ppo_ratio, ppo_intrusion))
    rows = [
        {
            **{name: 0.0 for name in COMPARED},
            "policy": policy,
            "scenario_set": scenarios,
            "episode": i,
            "seed": i,
            "training_seed": 0,
            "scenario_key": str(i),
            "scenario": f"{scenarios}/{i:03d}",
            "scenario_hash": str(i),
            "ssm_profile": study.ssm.profile(),
            "arrived": 1,
            "return": 200.0 + noise[i],
            "time_ratio": ratio + noise[i],
            "kinetic_intrusion_m2": intrusion + noise[i],
        }
        for policy, ratio, intrusion in made
        for scenarios in ("Crossing", "Corridor")
        for i in range(20)
    ]
    return summarise(pd.DataFrame(rows), study)


@pytest.mark.parametrize(
    ("ratio", "intrusion", "said"),
    [(1.3, 0.2, "- nobody"), (1.3, 0.02, "- `fuzzy_expert` by `ppo`"), (2.0, 0.3, "- `ppo` by")],
)
def test_the_page_says_who_is_dominated(ratio: float, intrusion: float, said: str) -> None:
    found = summary(ppo_ratio=ratio, ppo_intrusion=intrusion)
    text = page(
        TEMPLATE,
        record_of(dict.fromkeys(("tracks", "sonar", "before"), found)),
        name="a/record.json",
    )
    assert text.count(said) == 3  # once a study
    assert "a/record.json" in text
    assert "40 paired episodes" in text


def test_differences_are_those_to_the_expert() -> None:
    found = summary(ppo_ratio=1.3, ppo_intrusion=0.1)
    text = page(TEMPLATE, record_of(dict.fromkeys(("tracks", "sonar", "before"), found)), name="r")
    assert "| time_ratio | -0.2 | -0.2 to -0.2 |" in text
