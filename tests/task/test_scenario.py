from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import SCENARIOS, make_config
from hazbot_gym.core.geometry import route_pose
from hazbot_gym.core.recorded_table import rows_from
from hazbot_gym.core.state import PRESENT, SCRIPTED, SOCIAL_FORCE, WAITING
from hazbot_gym.task.scenario import Scenario, ScenarioSampler
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.tracks import resample
from tests.refusals import refused

YARD = """
name: whatever
path: {points: [[0, 0], [5, 0]]}
routes: [{points: [[3, -4], [3, 4]]}]
"""
MODELS = ("scripted", "social_force", "replay", "seeded")


def source(**overrides: Any) -> ScenarioSampler:
    return ScenarioSampler(make_config(**overrides))


def walker(x_m: float, y_m: float, vx_mps: float, vy_mps: float) -> dict[str, float]:
    return {"x_m": x_m, "y_m": y_m, "vx_mps": vx_mps, "vy_mps": vy_mps}


def fingerprint(scenario: Scenario) -> bytes:
    return scenario.people.tobytes() + scenario.recording.start.to_bytes(8)


@pytest.mark.parametrize("model", MODELS)
def test_key_alone_decides_the_scenario(model: str) -> None:
    first, second = (source(people={"model": model}) for _ in range(2))
    scenarios = [first.draw(key) for key in range(30)]

    again = [fingerprint(second.draw(key)) for key in reversed(range(30))]
    assert [fingerprint(scenario) for scenario in scenarios] == again[::-1]
    assert len(set(again)) > 20
    assert {len(scenario.people) for scenario in scenarios} == {first.people}


@pytest.mark.parametrize("model", MODELS)
def test_every_source_takes_the_largest_key(model: str) -> None:
    people = source(people={"model": model}).draw(2**63 - 1).people

    assert all(np.isfinite(people[name]).all() for name in ("x", "y", "enters_s", "s"))


def test_crowd_of_a_place_is_drawn_on_its_routes(tmp_path: Path) -> None:
    file = tmp_path / "yard.yaml"
    file.write_text(YARD)
    scenario = source(place=str(file), people={"count": (4, 4)}).draw(0)

    assert scenario.name == "yard"
    assert len(scenario.people) == 4
    assert scenario.people["route"].max() < len(scenario.place.routes) == 3
    assert scenario.recording.steps == 0


def test_walkers_start_where_they_are_told_and_go_on_straight() -> None:
    told = [walker(4.0, 0.8, -0.3, 0.4), walker(1.0, 2.0, 0.0, 0.0)]
    scenario = source(place="open", people={"walkers": told}).draw(5)
    people = scenario.people

    assert people["x"].tolist() == [4.0, 1.0]
    assert people["y"].tolist() == [0.8, 2.0]
    assert people["vx"].tolist() == [-0.3, 0.0]
    assert people["desired_speed"].tolist() == [0.5, 0.0]
    assert people["status"].tolist() == [PRESENT] * 2
    assert people["model"].tolist() == [SCRIPTED] * 2
    pose = route_pose(scenario.place.routes, 0, 2.5)
    assert pose == pytest.approx((4.0 - 1.5, 0.8 + 2.0, -0.6, 0.8))
    assert np.isfinite(scenario.place.routes).all(), "standing people have a route too"


def test_walkers_are_the_same_for_every_key_and_not_shared() -> None:
    walkers = source(people={"walkers": [walker(4.0, 0.8, -0.5, 0.0)]})
    first = walkers.draw(1)
    first.people["x"] = 99.0

    assert walkers.draw(1).people["x"].tolist() == [4.0]
    assert fingerprint(walkers.draw(2)) == fingerprint(walkers.draw(3))


@pytest.mark.parametrize("name", [name for name in SCENARIOS if not name.startswith("circle")])
def test_named_meeting_is_with_one_person_on_an_open_floor(name: str) -> None:
    scenario = source(scenario=name).draw(0)

    told = SCENARIOS[name]["people"]["walkers"][0]
    assert scenario.name == "open"
    assert len(scenario.place.walls) == name.endswith("+wall")
    assert [scenario.people[axis].item() for axis in ("x", "y")] == [told["x_m"], told["y_m"]]
    assert scenario.people["desired_speed"].item() == pytest.approx(0.5)


def test_replayed_people_are_where_they_were_recorded() -> None:
    expected = resample(synthetic_recording(), 0.05)
    people = list(zip(expected.first_steps, expected.tracks(), strict=True))
    for key in range(5):
        scenario = source(people={"model": "replay"}).draw(key)
        recording = scenario.recording

        assert scenario.name == "synthetic"
        assert len(recording.slots) - 1 == len(scenario.people)
        for step in (0, 100):
            now = recording.start + step
            there = [track[now - first] for first, track in people if 0 <= now - first < len(track)]
            rows = [rows_from(recording, slot, step) for slot in range(len(scenario.people))]
            seen = [recording.positions[row] for row, end in rows if row < end]
            assert np.array_equal(np.sort(seen, axis=0), np.sort(there, axis=0))


def test_replay_is_on_the_social_clock() -> None:
    fine = source(people={"model": "replay"}, clock={"social_s": 0.05}).draw(3).recording
    coarse = source(people={"model": "replay"}, clock={"social_s": 0.1}).draw(3).recording

    assert fine.steps == pytest.approx(2 * coarse.steps, abs=2)


def test_seeded_people_are_those_who_come_in_after_the_moment_that_is_drawn() -> None:
    # A short drive leaves most of the recording to choose from.
    fast = source(people={"model": "seeded"}, drive={"nominal_speed_mps": 1.0})
    firsts = [fast.draw(key).people[0] for key in range(40)]

    assert len({int(first["route"]) for first in firsts}) > 5
    assert np.mean([first["enters_s"] for first in firsts]) < 5.0


def test_seeded_people_answer_to_the_robot_and_walk_on_their_own_routes() -> None:
    scenario = source(people={"model": "seeded"}).draw(0)
    expected = scenario.people[scenario.people["status"] == WAITING]

    assert len(expected) > 10
    assert set(expected["model"]) == {SOCIAL_FORCE}
    assert len(scenario.place.routes) == synthetic_recording().people
    assert scenario.recording.steps == 0


@pytest.mark.parametrize(
    ("overrides", "complaint"),
    [
        ({"place": "attic"}, "place ... 'attic'"),
        ({"place": "doorway", "people": {"family": "crossing"}}, "people.family"),
        ({"people": {"model": "replay"}, "tracks": "/no/such/file"}, "tracks"),
    ],
)
def test_impossible_source_is_one_clear_line(overrides: dict[str, Any], complaint: str) -> None:
    with refused(complaint):
        source(**overrides)
