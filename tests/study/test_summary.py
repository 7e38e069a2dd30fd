from __future__ import annotations

import io
import json

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.evaluation.metrics import HEADLINE, PER_KM, means
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.summary import COMPARED, RATES, summarise, summarise_one
from hazbot_gym.study.terminal_tables import study_tables
from hazbot_gym.utils.terminal import output_console
from tests.refusals import refused

EACH = [name for name in HEADLINE if name != PER_KM]  # of a single episode
STUDY = StudyConfig(
    policies=("constant:0.5", "fuzzy_expert:rules=literal8"),
    sets=tuple(ScenarioSet(name=name, env="hazbot_gym/Corridor-v1") for name in ("easy", "hard")),
    episodes=20,
    resamples=200,
)


def made_up_rows(study: StudyConfig = STUDY) -> list[dict[str, object]]:
    """Rows in which the second policy's discomfort is less by exactly 0.5 s in every scenario."""
    rows = []
    for scenarios in study.sets:
        for better, policy in enumerate(study.policies):
            rng = np.random.default_rng(0)
            for index in range(study.episodes):
                noise = rng.normal()
                rows.append(
                    dict.fromkeys((*EACH, *RATES), 0)
                    | {
                        "policy": policy,
                        "scenario_set": scenarios.name,
                        "episode": index,
                        "seed": index,
                        "training_seed": 0,
                        "scenario_key": str(index),
                        "scenario": f"{scenarios.name}/{index:03d}",
                        "scenario_hash": str(index),
                        "ssm_profile": study.ssm.profile(),
                        "arrived": int(index > 1),
                        "driven_m": 12.5,
                        "discomfort_s": 3.0 + noise - 0.5 * better,
                        "delay_s": 1.25,
                        "return": -1234.5 + noise,
                        "contact_speed_mps": float("nan"),
                    }
                )
    return rows


def test_every_policy_has_means_and_intervals_in_every_set_and_in_all() -> None:
    summary = summarise(pd.DataFrame(made_up_rows()), STUDY)
    assert list(summary["sets"]) == ["easy", "hard", "all sets"]
    result = summary["sets"]["hard"]["constant:0.5"]
    assert result["episodes"] == 20
    assert result["metrics"]["arrived"]["mean"] == 0.9
    assert result["metrics"]["arrived"]["low"] == pytest.approx(0.699, abs=1e-3)  # Wilson
    assert result["metrics"]["delay_s"] == {"mean": 1.25, "low": 1.25, "high": 1.25}
    assert result["metrics"]["contact_speed_mps"] == {"mean": None, "low": None, "high": None}
    assert not {"episode", "seed", "training_seed"} & set(result["metrics"])
    assert summary["sets"]["all sets"]["constant:0.5"]["episodes"] == 40


def test_differences_are_paired_and_against_the_reference() -> None:
    summary = summarise(pd.DataFrame(made_up_rows()), STUDY)
    policy = summary["sets"]["easy"]["fuzzy_expert:rules=literal8"]
    assert set(policy["difference"]) == set(COMPARED)
    difference = policy["difference"]["discomfort_s"]
    assert [difference[name] for name in ("mean", "low", "high")] == [-0.5, -0.5, -0.5]
    assert difference["less"] == 1.0  # in every scenario
    assert difference["p"] == pytest.approx(0.0)  # the same difference in every scenario
    others = [policy["difference"][name]["p_holm"] for name in COMPARED if name != "discomfort_s"]
    assert others == [1.0] * 5
    width = policy["metrics"]["discomfort_s"]
    assert width["high"] - width["low"] > 0.3


def test_a_single_scenario_has_means_and_no_intervals() -> None:
    study = STUDY.model_copy(update={"episodes": 1})
    summary = summarise(pd.DataFrame(made_up_rows(study)), study)
    for name in ("easy", "all sets"):  # each set is resampled by itself
        policy = summary["sets"][name]["fuzzy_expert:rules=literal8"]
        assert policy["metrics"]["delay_s"] == {"mean": 1.25, "low": None, "high": None}
        assert policy["metrics"]["arrived"]["low"] is policy["metrics"]["arrived"]["high"] is None
        difference = policy["difference"]["discomfort_s"]
        assert (difference["mean"], difference["low"], difference["p"]) == (-0.5, None, None)
        assert policy["return_gain"]["low"] is None
        assert policy["tails"]["delay_s"]["high"] is None


def test_the_same_rows_give_the_same_bytes() -> None:
    one, other = (
        json.dumps(summarise(pd.DataFrame(made_up_rows()), STUDY), allow_nan=False)
        for _ in range(2)
    )
    assert one == other


def test_rows_of_two_profiles_do_not_mix() -> None:
    rows = made_up_rows()
    rows[3]["ssm_profile"] = "another"
    with refused("different thresholds"):
        summarise(pd.DataFrame(rows), STUDY)


def test_policies_must_have_met_the_same_scenarios() -> None:
    rows = made_up_rows()
    rows[3]["scenario_key"] = "another"
    with refused("episode 3 of 'easy'"):
        summarise(pd.DataFrame(rows), STUDY)


def test_scenarios_of_the_bank_must_be_as_it_has_them() -> None:
    rows = made_up_rows()
    rows[5]["scenario"] = "test/Crossing/005"
    with refused("'test/Crossing/005' ... hash 5"):
        summarise(pd.DataFrame(rows), STUDY)


def test_means_leave_out_what_is_not_defined() -> None:
    rows = made_up_rows()[:4]
    rows[0]["delay_s"] = float("nan")
    for row in rows:
        row["return"] = float("nan")
    assert means(rows)["delay_s"] == 1.25
    assert means(rows)["return"] is None
    assert tuple(means(rows)) == HEADLINE


def test_contacts_per_kilometre_are_all_contacts_over_the_whole_distance() -> None:
    rows = made_up_rows()[:40]
    for row in rows[:2]:
        row["contact_robot_caused"], row["driven_m"] = 1, 2.5
    assert means(rows)[PER_KM] == pytest.approx(2 / (0.0025 * 2 + 0.0125 * 38))


@pytest.mark.parametrize("contacts", [0, 1, 5])
def test_an_interval_of_contacts_per_kilometre_is_at_least_that_of_their_share(
    contacts: int,
) -> None:
    rows = made_up_rows()[:20]
    for row in rows[:contacts]:
        row["contact_robot_caused"] = 1
    found = summarise_one(rows, seed=0)["metrics"]
    share, per_km = found["contact_robot_caused"], found[PER_KM]
    assert per_km["mean"] == pytest.approx(80.0 * contacts / 20)  # 80 drives are a kilometre
    assert per_km["low"] <= 80.0 * share["low"] + 1e-6
    assert per_km["high"] >= 80.0 * share["high"] - 1e-6


def test_one_policy_is_summarised_like_the_same_policy_in_a_study() -> None:
    rows = made_up_rows()
    alone = summarise_one(rows[:20], seed=0)
    within = summarise(pd.DataFrame(rows), STUDY)["sets"]["easy"]["constant:0.5"]
    assert alone["metrics"]["arrived"] == within["metrics"]["arrived"]
    assert alone["metrics"]["return"]["mean"] == within["metrics"]["return"]["mean"]


@pytest.mark.parametrize("width", [120, 80, 60])
def test_tables_fit_every_terminal_with_no_name_and_no_interval_cut_off(width: int) -> None:
    out = io.StringIO()
    summary = summarise(pd.DataFrame(made_up_rows()), STUDY)
    output_console(out, width=width).print(study_tables(summary, is_verbose=True))
    lines = out.getvalue().splitlines()
    assert max(map(len, lines)) <= width
    assert "…" not in out.getvalue()
    for text in ("easy", "hard", "all sets", "rules=literal8", "-1235..-1234"):
        assert text in out.getvalue()
    assert ("70..97" in out.getvalue()) == (width == 120)
    assert ("Too narrow to show: contact by person" in out.getvalue()) == (width < 120)


def test_the_headline_is_the_only_table_unless_more_is_asked_for() -> None:
    out = io.StringIO()
    output_console(out).print(study_tables(summarise(pd.DataFrame(made_up_rows()), STUDY)))
    assert "easy:" not in out.getvalue()
    assert "all sets: 40 episodes" in out.getvalue()


def test_rates_of_learners_are_not_sure_of_what_all_their_seeds_did_alike() -> None:
    study = STUDY.model_copy(update={"sets": STUDY.sets[:1]})
    rows = made_up_rows(study)
    again = [{**row, "training_seed": 1} for row in rows if row["policy"] == study.policies[1]]
    for row in (*rows, *again):
        row["timeout"] = 0
    result = summarise(pd.DataFrame([*rows, *again]), study)["sets"]["easy"][study.policies[1]]
    assert result["training_seeds"] == 2
    assert result["metrics"]["timeout"] == {
        "mean": 0.0,
        "low": 0.0,
        "high": pytest.approx(0.161, abs=1e-3),
    }
    assert result["metrics"]["arrived"]["low"] <= 0.699  # of 20 scenarios, not of 40 episodes


def test_seeds_of_a_learner_that_differ_widen_its_intervals() -> None:
    study = STUDY.model_copy(update={"sets": STUDY.sets[:1]})
    rows = made_up_rows(study)
    other = [
        {**row, "training_seed": 1, "delay_s": 1.75}
        for row in rows
        if row["policy"] == study.policies[1]
    ]
    result = summarise(pd.DataFrame([*other, *rows]), study)["sets"]["easy"][study.policies[1]]
    for found, mean in ((result["metrics"], 1.5), (result["difference"], 0.25)):
        assert found["delay_s"]["mean"] == mean
        assert found["delay_s"]["low"] < mean - 0.25  # Student's t: beyond both seeds
        assert found["delay_s"]["high"] > mean + 0.25


def test_return_at_other_prices_charges_discomfort_otherwise() -> None:
    summary = summarise(pd.DataFrame(made_up_rows()), STUDY)
    metrics = summary["sets"]["easy"]["constant:0.5"]["metrics"]
    earned, cheap, dear = (
        metrics[name]["mean"] for name in ("return", "return_at_2", "return_at_8")
    )
    felt = metrics["discomfort_s"]["mean"]
    # Numbers are rounded to nine digits.
    assert cheap - earned == pytest.approx(2.0 * felt, abs=1e-4)
    assert dear - earned == pytest.approx(-4.0 * felt, abs=1e-4)


def test_each_policy_has_its_pareto_standing_and_clearances_in_every_set() -> None:
    rows = pd.DataFrame(made_up_rows())
    rows["delay_s"] = np.where(rows["policy"] == STUDY.policies[1], 1.0, 9.0)
    rows["discomfort_s"] = rows["delay_s"] + 0.1 * rows["arrived"]
    rows["clearance_min_m"] = np.where(rows["episode"] < 5, np.inf, 0.1 * rows["episode"])
    for block in summarise(rows, STUDY)["sets"].values():
        worse, better = (block[policy] for policy in STUDY.policies)
        assert (worse["dominated_by"], better["dominated_by"]) == ([STUDY.policies[1]], [])
        quantiles = worse["clearance_quantiles_m"]
        assert (quantiles[0], quantiles[50], quantiles[75], quantiles[76]) == (0.5, 1.4, 1.9, None)


@pytest.mark.parametrize(("episodes", "one_in"), [(1, 1), (20, 13)])
def test_the_rule_of_three_counts_the_scenarios_of_the_headline(episodes: int, one_in: int) -> None:
    study = STUDY.model_copy(update={"episodes": episodes})
    summary = summarise(pd.DataFrame(made_up_rows(study)), study)
    assert summary["headline"]["zero_is_below_one_in"] == one_in
