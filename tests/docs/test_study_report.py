"""Tables and sentences from the studies of the shipped policy, which can come out either way."""

from __future__ import annotations

from typing import Any

import pytest
from keep_study import KEPT, record_of
from study_report import (
    csv_of,
    many_table,
    shield_table,
    shipped_gain,
    shipped_prices,
    shipped_table,
)

from tests.refusals import says


def estimate(mean: float, half: float = 0.01) -> dict[str, float]:
    return {"mean": mean, "low": mean - half, "high": mean + half}


def policy(gain: float, **metrics: float) -> dict[str, Any]:
    plain = dict.fromkeys(KEPT, 0.0) | {"delay_s": 1.5, "return": 50.0 + gain}
    return {
        "episodes": 1000,
        "training_seeds": 1,
        "metrics": {name: estimate(value) for name, value in (plain | metrics).items()},
        "return_gain": estimate(gain),
    }


def shipped(gain: float) -> dict[str, Any]:
    """Return a record in which one rule has twice the learner's gain over another."""
    gains = {"fuzzy_expert": -9.0, "mpc": 0.0, "idm": 2.0 * gain, "ppo from rules": gain}
    block = {name: policy(each, discomfort_s=0.5) for name, each in gains.items()}
    sets = {"test/Crossing": block, "test/Leading": block, "test": block}
    found = record_of({"study": "x", "reference": "mpc", "sets": sets})
    returns = [50.0 + gain - 1.0, 50.0 + gain + 1.0]
    return {"shipped": found | {"over_expert": estimate(9.0 + gain), "returns": returns}}


def test_headline_for_the_readme_has_every_policy_and_counts_environments() -> None:
    table = shipped_table(shipped(3.0))
    assert "| `ppo from rules` | 1.50 | 0.00 | 0.000 | 0.00 | 0.00 | 0.0 | 53.0 |" in table
    assert "1000 test scenarios in 2 environments" in table


def test_half_a_second_of_discomfort_costs_what_each_price_says() -> None:
    assert "| `ppo from rules` | 54.0 | 53.0 | 51.0 |" in shipped_prices(shipped(3.0))


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


def test_contacts_are_in_percent_with_intervals_test_scenarios_first() -> None:
    block = {"ppo": policy(0.0, contact_robot_caused=0.02)}
    tiers = {"sets": {"sonar": block, "tracks": block}}
    table = shield_table({"shield": tiers, "shield_test": {"sets": {"test": block}}})
    first, second, third = table.splitlines()[2:]
    assert first.startswith("| test | `ppo` | 1,000 | 2.000 (1.000 to 3.000) |")
    assert second.startswith("| tracks |")
    assert third.startswith("| sonar |")


def test_the_csv_has_a_line_for_each_set_policy_and_metric() -> None:
    lines = csv_of({"test": {"ppo": policy(3.0)}}).splitlines()
    assert len(lines) == 1 + len(KEPT)
    assert "test,ppo,return,53.0,52.99,53.01" in lines


def test_many_scenarios_say_whether_the_shipped_policy_is_ahead() -> None:
    block = {"mpc": policy(0.0), "ppo": policy(3.0)}
    text = many_table({"many": {"reference": "mpc", "sets": {"tracks": block}}})
    assert "| `ppo` |" in text
    assert "1,000 further scenarios, the shipped `ppo` earns more than `mpc`: its" in text
