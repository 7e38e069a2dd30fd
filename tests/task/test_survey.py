"""The survey's reward term in each of its outcomes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.gas_sensor import GAS_SENSORS, Nose, nose_of
from hazbot_gym.core.state import GAS, Records, as_record, records
from hazbot_gym.task.outcome import ARRIVED, CONTACT_PERSON, CONTACT_WALL, RUNNING, TIMEOUT
from hazbot_gym.task.reward import SURVEY, TERMS
from hazbot_gym.task.step_record import STEP
from hazbot_gym.task.survey import CAUSED, FALSE_ALARM, survey_kernel

NOSE = nose_of(GAS_SENSORS["TGS2611"], 0.1)
LOUD, CLEAN = 2.0 * NOSE.threshold, 0.0
ENDS = (ARRIVED, CONTACT_PERSON, CONTACT_WALL, TIMEOUT)
FOUND, MISSED, NOTHING = 1.0, -1.0, 0.0


class Decision(NamedTuple):
    """Sensor and outcome at a decision."""

    onset: int = 0
    response: float = CLEAN
    outcome: int = RUNNING


def surveyed(*decisions: Decision, leak: int = 1, nose: Nose = NOSE) -> tuple[list[float], Records]:
    """Return the terms of decisions, and the record after them."""
    gas, step, terms = records(GAS, 1), records(STEP, 1), np.full(len(TERMS) + 1, 0.5)
    gas["leak"]["is_there"], got = leak, []
    for decision in decisions:
        gas["smell"]["onset"], gas["smell"]["response"] = decision.onset, decision.response
        step["outcome"] = decision.outcome
        survey_kernel(gas, step, as_record(nose), terms)
        got.append(float(terms[SURVEY]))
        assert (terms[:SURVEY] == 0.5).all()
    return got, gas


QUIET, ALARM, FALSE = Decision(), Decision(1, LOUD), Decision(1, CLEAN)


def test_an_alarm_that_gas_causes_reports_the_leak_once() -> None:
    terms, gas = surveyed(QUIET, ALARM, QUIET, ALARM, QUIET, ALARM)
    assert terms == [NOTHING, FOUND, NOTHING, NOTHING, NOTHING, NOTHING]
    assert (gas["is_reported"], gas["false_alarms"]) == (1, 0)


@pytest.mark.parametrize("leak", [0, 1])
def test_an_alarm_that_noise_causes_costs_each_time_and_reports_nothing(leak: int) -> None:
    terms, gas = surveyed(FALSE, QUIET, FALSE, leak=leak)
    assert terms == [FALSE_ALARM, NOTHING, FALSE_ALARM]
    assert (gas["is_reported"], gas["false_alarms"]) == (0, 2)


def test_a_false_alarm_does_not_stand_in_the_way_of_a_report() -> None:
    terms, gas = surveyed(FALSE, QUIET, ALARM, FALSE)
    assert terms == [FALSE_ALARM, NOTHING, FOUND, FALSE_ALARM]
    assert (gas["is_reported"], gas["false_alarms"]) == (1, 2)


@pytest.mark.parametrize("outcome", ENDS)
@pytest.mark.parametrize(
    ("before", "leak", "expected"),
    [
        (QUIET, 1, MISSED),
        (FALSE, 1, MISSED),
        (ALARM, 1, NOTHING),
        (QUIET, 0, NOTHING),
        (FALSE, 0, NOTHING),
    ],
    ids=["missed", "missed after a false alarm", "reported", "no leak", "no leak, false alarm"],
)
def test_at_the_end_a_leak_that_nothing_has_reported_is_missed(
    outcome: int, before: Decision, leak: int, expected: float
) -> None:
    terms, _ = surveyed(before, QUIET._replace(outcome=outcome), leak=leak)
    assert terms[-1] == expected


@pytest.mark.parametrize("outcome", ENDS)
def test_an_alarm_of_the_last_decision_counts(outcome: int) -> None:
    assert surveyed(ALARM._replace(outcome=outcome))[0] == [FOUND]
    assert surveyed(FALSE._replace(outcome=outcome), leak=0)[0] == [FALSE_ALARM]
    terms, gas = surveyed(FALSE._replace(outcome=outcome))
    assert terms == [MISSED]
    assert gas["false_alarms"] == 1


def test_gas_is_the_cause_from_a_share_of_the_threshold_on() -> None:
    least = CAUSED * NOSE.threshold
    assert surveyed(Decision(1, least))[0] == [FOUND]
    assert surveyed(Decision(1, 0.999 * least))[0] == [FALSE_ALARM]


@given(
    st.lists(
        st.builds(Decision, st.integers(0, 1), st.floats(0.0, 1.0), st.just(RUNNING)), max_size=8
    ),
    st.sampled_from(ENDS),
    st.integers(0, 1),
)
def test_term_is_within_its_range_and_a_leak_pays_or_costs_once(
    decisions: list[Decision], outcome: int, leak: int
) -> None:
    terms, gas = surveyed(*decisions, QUIET._replace(outcome=outcome), leak=leak)
    assert all(-1.0 <= term <= 1.0 for term in terms)
    assert terms.count(FOUND) + terms.count(MISSED) == max(leak, int(gas["is_reported"][0]))
