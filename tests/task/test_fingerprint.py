from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.task.fingerprint import PARAMETERS, fingerprint, parameters
from hazbot_gym.task.scenario import Scenario, ScenarioSampler


def drawn(key: int = 7, **overrides: Any) -> Scenario:
    return ScenarioSampler(make_config(**overrides)).draw(key)


def test_everybody_who_comes_is_written_down_with_what_was_drawn() -> None:
    scenario = drawn(people={"count": [2, 2], "family": "leading"})
    leader, other = parameters(scenario)
    assert leader.keys() == other.keys() == PARAMETERS.keys()
    assert leader["desired_speed_mps"] == pytest.approx(
        scenario.people[0]["desired_speed"], abs=1e-6
    )
    assert leader["x_m"] == pytest.approx(scenario.people[0]["x"], abs=1e-6)
    assert isinstance(leader["route"], int)


def test_who_does_not_come_is_not_written_down() -> None:
    counts = {len(parameters(drawn(key, people={"count": [1, 3]}))) for key in range(30)}
    assert counts == {1, 2, 3}


def test_the_same_scenario_has_the_same_hash_and_another_key_another() -> None:
    assert fingerprint(drawn(7)) == fingerprint(drawn(7))
    assert len({fingerprint(drawn(key)) for key in range(20)}) == 20


@pytest.mark.parametrize(
    "change",
    [
        {"people": {"speeds": {"mean_mps": 1.3}}},
        {"people": {"reaction_shares": (0.0, 1.0, 0.0, 0.0)}},
        {"people": {"model": "scripted"}},
        {"place_options": {"width_m": 2.5}},
        {"place_options": {"length_m": 12.1}},
        {"place": "doorway"},
    ],
    ids=str,
)
def test_whatever_changes_who_comes_or_where_changes_the_hash(change: dict[str, Any]) -> None:
    assert fingerprint(drawn(**change)) != fingerprint(drawn())


def test_walls_count_even_where_nobody_walks_differently() -> None:
    scenario = drawn()
    moved = scenario._replace(place=scenario.place._replace(walls=scenario.place.walls + 0.001))
    assert fingerprint(moved) != fingerprint(scenario)


def test_sensors_and_what_the_robot_is_told_leave_the_hash_alone() -> None:
    other = drawn(tier="sonar", sensors={"tracker": {"dropout": 0.5}})
    assert fingerprint(other) == fingerprint(drawn())


def test_a_last_digit_does_not_show() -> None:
    scenario = drawn()
    shifted = scenario.people.copy()
    shifted["offset"] = np.nextafter(shifted["offset"], np.inf)
    assert fingerprint(scenario._replace(people=shifted)) == fingerprint(scenario)


def test_recorded_people_count_by_where_they_stand_first() -> None:
    scenario = drawn(people={"model": "replay"})
    later = scenario._replace(
        recording=scenario.recording._replace(start=scenario.recording.start + 1)
    )
    assert fingerprint(later) != fingerprint(scenario)
