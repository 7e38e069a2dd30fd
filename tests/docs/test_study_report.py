"""The page on the full study: what it is made of, and targets that can come out either way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import study_report
from study_record import KEPT, RATES, record_of, small_record_of
from study_report import first_table, page, recorded_people, shipped_gain, shipped_table
from study_targets import sonar_targets, tracks_targets

from hazbot_gym.study.headline import POOLED
from hazbot_gym.study.summary import COMPARED, TAILS
from tests.refusals import says

TEMPLATE = (Path(__file__).parents[2] / "docs" / "_templates_md" / "study_tables.md").read_text(
    encoding="utf-8"
)
POLICIES = ("fuzzy_expert", "ssm:mode=directional", "fuzzy_expert, tuned", "residual")
FRONTS = ("fuzzy_expert", "residual ppo, three prices")


def estimate(mean: float, half: float = 0.01) -> dict[str, float]:
    return {"mean": mean, "low": mean - half, "high": mean + half}


def policy(**metrics: float) -> dict[str, Any]:
    plain = dict.fromkeys((*KEPT, *RATES), 0.0) | {"delay_s": 1.5, "discomfort_s": 0.05}
    return {
        "episodes": 1000,
        "training_seeds": 1,
        "metrics": {name: estimate(value) for name, value in (plain | metrics).items()},
        "difference": {name: estimate(-0.1) | {"p": 0.01, "p_holm": 0.04} for name in COMPARED},
        "return_gain": estimate(2.0) | {"probability": estimate(0.96)},
        "tails": {name: estimate(0.3) for name in TAILS},
    }


def summary(**learner: float) -> dict[str, Any]:
    block = {name: policy() for name in POLICIES} | {"residual": policy(**learner)}
    regret = {
        name: {
            "regret": estimate(1.0),
            "avoidable_delay_s": estimate(0.02),
            "normalised": estimate(0.97),
        }
        for name in POLICIES
    }
    front = {
        name: {
            "points": [{"policy": name, "on_front": True}],
            "hypervolume": estimate(0.04 + 0.02 * i, 0.001),
            "difference": estimate(0.02 * i, 0.001),
            "behind": estimate(0.02 * (i + 1 - len(FRONTS)), 0.001),
        }
        for i, name in enumerate(FRONTS)
    }
    best = {"episodes": 50, "constant": None, "best": {}, "policies": regret}
    return {
        "study": "abc",
        "confidence": 0.95,
        "reference": "fuzzy_expert, tuned",
        "sets": {"test": block, "test/Crossing": block, "test/Leading": block},
        "fronts": {"together": front},
        "oracle": {"exact": best, "searched": best},
    }


def record(**learner: float) -> dict[str, Any]:
    training = {
        "name": "residual",
        "config": "r.yaml",
        "seeds": 10,
        "decisions": 3_000_000,
        "seconds": 120.0,
        "validation_return": 260.0,
    }
    session = {
        "command": "hazbot study",
        "seconds": 3000.0,
        "peak_memory_gb": 1.2,
        "prepared": 9,
        "shards": 100,
        "decisions": 10**6,
    }
    return record_of(
        {
            "summary": summary(**learner),
            "manifest": {
                "commit": "1" * 40,
                "machine": {"processor": "P", "cores": 2},
                "environments": {"test/Crossing": {}, "test/Leading": {}},
            },
            "sessions": [session],
            "trainings": [training],
            "policies": list(POLICIES),
            "shown": ["fuzzy_expert, tuned", "residual"],
            "tuned": {"fuzzy_expert, tuned": {"policy": "fuzzy_expert:scale=1", "at_a_bound": []}},
        }
    )


SMALL = {
    name: small_record_of(
        {
            "study": "x",
            "reference": "ssm",
            "sets": {
                POOLED: {"ppo": policy()},
                "real people, replay": {"ppo": policy()},
                "real people, seeded": {"ppo": policy()},
            },
        }
    )
    for name in ("contacts", "people")
}
GOOD = {"delay_s": 1.4, "discomfort_s": 0.02}


def test_page_leaves_no_placeholder_and_shows_every_policy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(study_report, "FIRST_POLICIES", ("residual",))
    found = {name: record(**GOOD) for name in ("tracks", "sonar", "observations")} | SMALL
    text = page(TEMPLATE, found, name="benchmarks/study.json")
    assert "$" not in text
    for name in POLICIES:
        assert f"`{name}`" in text
    assert "1.40 (1.39 to 1.41)" in text


def test_headline_of_the_first_study_has_the_chosen_policies(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(study_report, "FIRST_POLICIES", ("residual",))
    table = first_table({"tracks": record(**GOOD)})
    assert "| `residual` | 1.40 | 0.00 | 0.000 | 0.00 | 0.00 | 0.0 |" in table
    assert "directional" not in table


def shipped(gain: float) -> dict[str, Any]:
    """Return a record in which one rule has twice the learner's gain over another."""
    gains = {"fuzzy_expert": -9.0, "mpc": 0.0, "idm": 2.0 * gain, "ppo from rules": gain}
    block = {
        name: policy(**{"return": 50.0 + each}) | {"return_gain": estimate(each)}
        for name, each in gains.items()
    }
    sets = {"test/Crossing": block, "test/Leading": block, "test": block}
    found = small_record_of({"study": "x", "reference": "mpc", "sets": sets})
    return {"shipped": found | {"over_expert": estimate(9.0 + gain)}}


def test_headline_for_the_readme_has_every_policy_and_counts_environments() -> None:
    table = shipped_table(shipped(3.0))
    assert "| `ppo from rules` | 1.50 | 0.00 | 0.000 | 0.00 | 0.00 | 0.0 | 53.0 |" in table
    assert "1000 test scenarios in 2 environments" in table


@pytest.mark.parametrize(
    ("gain", "verdict", "higher"),
    [
        (
            3.0,
            "earns more than",
            "`idm`. ... `Crossing-v1` (`idm`, by 3.0), `Leading-v1` (`idm`, by 3.0).",
        ),
        (
            -3.0,
            "earns less than",
            "`mpc`. ... `Crossing-v1` (`mpc`, by 3.0), `Leading-v1` (`mpc`, by 3.0).",
        ),
        (0.005, "does not clearly earn more than", "`idm`. In ... or more: none."),
    ],
)
def test_result_of_the_learner_follows_the_interval_and_names_rules_that_earn_more(
    gain: float, verdict: str, higher: str
) -> None:
    text = shipped_gain(shipped(gain))
    says(text, f"earns more than the fuzzy expert ... It {verdict} `mpc`")
    says(text, f"Rules with a higher mean return: {higher}")
    assert f"higher by {9.0 + gain:.1f} (" in text


def test_where_no_rule_earns_more_the_result_says_so() -> None:
    found = shipped(3.0)
    for block in found["shipped"]["sets"].values():
        del block["idm"]
    text = shipped_gain(found)
    says(text, "higher mean return: none. In ... by 1 s or more: none.")


@pytest.mark.parametrize(
    ("replay", "seeded", "verdict"),
    [
        (-5.0, -2.0, "earns less than"),
        (5.0, 2.0, "earns more than"),
        (5.0, -2.0, "does not clearly earn more"),
        (5.0, 0.005, "does not clearly earn more"),  # within the interval of zero
        (-5.0, -0.005, "does not clearly earn more"),
    ],
)
def test_result_among_recorded_people_follows_the_intervals(
    replay: float, seeded: float, verdict: str
) -> None:
    gains = {"replay": replay, "seeded": seeded}
    sets = {
        f"real people, {name}": {"ppo": {"return_gain": estimate(gain)}}
        for name, gain in gains.items()
    }
    text = recorded_people({"people": {"reference": "ssm", "sets": sets}})
    assert verdict in text
    assert f"{replay:.1f} (" in text


def test_all_targets_can_be_reached() -> None:
    found = record(**GOOD)
    assert all(target.is_reached for target in tracks_targets(found))
    assert all(target.is_reached for target in sonar_targets(found))


@pytest.mark.parametrize(
    ("changes", "aim"),
    [
        ({"discomfort_s": 0.06}, "discomfort no higher"),
        ({"ssm_violation": 0.1}, "SSM violation no higher"),
        ({"contact_robot_caused": 0.001}, "no contact by the robot"),
        ({"delay_s": 1.6, "discomfort_s": 0.08}, "in no group of scenarios dominated"),
    ],
)
def test_a_target_that_is_missed_says_so(changes: dict[str, float], aim: str) -> None:
    missed = [
        each.aim for each in tracks_targets(record(**(GOOD | changes))) if not each.is_reached
    ]
    assert any(each.startswith(aim) for each in missed)


def test_targets_against_the_oracle_are_missed_below_their_marks() -> None:
    found = record(**GOOD)
    found["oracle"]["exact"]["policies"]["residual"]["normalised"]["mean"] = 94.0
    found["together"]["test"]["residual"]["return_gain"]["probability"]["mean"] = 0.9
    found["fronts"]["together"]["residual ppo, three prices"]["hypervolume"]["low"] = 0.04
    reached = [target.is_reached for target in tracks_targets(found)]
    assert reached == [True, True, False, False, True, False, True]


def test_an_old_record_tells_ties_of_areas_and_p_values_at_the_floor() -> None:
    found = record(**GOOD)
    largest, other = found["fronts"]["together"].values()
    assert not study_report._is_tie(largest, other)
    for family in (largest, other):
        del family["behind"]
        family["hypervolume"] = estimate(0.04)
    assert study_report._is_tie(largest, other)
    assert study_report._p({"p": 0.001, "p_holm": 0.04}, 0.001) == "<= 0.04"
    assert study_report._p({"p": 0.002, "p_holm": 0.04}, 0.001) == "0.04"
