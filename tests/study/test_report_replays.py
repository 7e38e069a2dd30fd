from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.errors import HazbotError
from hazbot_gym.study import report, report_places, report_player
from hazbot_gym.study.config import ScenarioSet, StudyConfig
from hazbot_gym.study.episode import X, Y
from hazbot_gym.study.report_replays import Replay, check, choose, replay_set
from hazbot_gym.study.rollout import Block, run_block


@pytest.fixture(scope="module")
def study(finished: Path) -> report.Study:
    return report.read(finished)


@pytest.fixture(scope="module")
def replays(study: report.Study) -> list[Replay]:
    scenarios = next(each for each in study.config.all_sets if each.name == "Crossing")
    return replay_set(study.config, scenarios, report.rows_of(study, "Crossing"), study.specs)


def episodes(**columns: list[float]) -> pd.DataFrame:
    return pd.DataFrame({"episode": range(len(columns["return"])), **columns})


def test_median_closest_and_slowest_episodes_are_chosen() -> None:
    rows = episodes(
        **{
            "return": [5.0, 1.0, 3.0, 2.0],
            "clearance_min_m": [0.5, 0.1, 0.4, np.inf],
            "time_ratio": [1.0, 1.5, 1.2, 2.0],
        }
    )
    assert choose(rows) == {3: "median and slowest", 1: "closest"}


def test_one_episode_is_all_three() -> None:
    rows = episodes(**{"return": [5.0], "clearance_min_m": [0.5], "time_ratio": [1.0]})
    assert choose(rows) == {0: "median and closest and slowest"}


def test_every_policy_drives_through_the_chosen_scenarios(
    study: report.Study, replays: list[Replay]
) -> None:
    for replay in replays:
        assert list(replay.runs) == list(study.config.policies)
        starts = [run.pose[0].tolist() for run in replay.runs.values()]
        assert starts == [starts[0]] * len(starts)
    assert "median" in replays[0].why


def test_the_pymunk_engine_gives_the_same_episodes(
    study: report.Study, replays: list[Replay]
) -> None:
    reference = study.config.model_copy(update={"engine": "pymunk"})
    scenarios = next(each for each in study.config.all_sets if each.name == "Crossing")
    again = replay_set(reference, scenarios, report.rows_of(study, "Crossing"), study.specs)
    for ours, theirs in zip(replays, again, strict=True):
        for policy, run in ours.runs.items():
            np.testing.assert_allclose(run.pose, theirs.runs[policy].pose, atol=1e-6)


def test_discrete_speeds_give_the_same_episodes() -> None:
    scenarios = ScenarioSet(
        name="levels", env="hazbot_gym/Crossing-v0", overrides={"action_type": "discrete"}
    )
    study = StudyConfig(policies=("constant:0.4", "stop_on_sight"), sets=(scenarios,))
    blocks = [Block(policy, scenarios, 0, 2, study.seed) for policy in study.policies]
    rows = pd.DataFrame([row for block in blocks for row in run_block(block)])
    assert set(
        replay_set(study, scenarios, rows, dict(zip(study.names, study.names, strict=True)))[0].runs
    ) == set(study.policies)


def test_an_episode_that_gives_other_numbers_is_refused_by_name(study: report.Study) -> None:
    rows = study.rows.copy()
    rows.loc[rows["policy"] == "stop_on_sight", "clearance_min_m"] += 0.01
    scenarios = study.config.all_sets[0]
    with pytest.raises(HazbotError, match="'E[*]' with 'stop_on_sight' now gives clearance_min_m"):
        replay_set(
            study.config, scenarios, rows[rows["scenario_set"] == scenarios.name], study.specs
        )


@pytest.mark.parametrize(
    ("name", "value"), [("scenario_key", "8"), ("time_s", 10.1), ("contact_speed_mps", 0.0)]
)
def test_every_kind_of_number_is_compared(name: str, value: Any) -> None:
    again = {"scenario_key": "7", "time_s": 10.0, "contact_speed_mps": float("nan")}
    labels = {"episode": 0, "scenario_set": "E*", "policy": "constant"}
    check(again, again | labels)
    with pytest.raises(HazbotError, match=f"now gives {name}"):
        check(again, again | labels | {name: value})


def test_packed_replays_are_the_episodes_to_the_centimetre(replays: list[Replay]) -> None:
    packed = report_player.pack({"Crossing": replays})
    content = json.loads(zlib.decompress(base64.b64decode(packed)))
    replay = content["sets"]["Crossing"][0]
    policy, run = next(iter(replay["runs"].items()))
    episode = replays[0].runs[policy]
    assert run["dt_s"] == 0.1
    np.testing.assert_allclose(np.cumsum(run["x"]), 100 * episode.pose[:, 0], atol=0.5)
    np.testing.assert_allclose(np.cumsum(run["speed"]), 100 * episode.speed_mps, atol=0.5)
    someone_x = np.cumsum(run["people"][0][0])
    is_seen = someone_x < content["nobody"]
    expected = 100 * episode.people[:, 0, X]
    np.testing.assert_allclose(someone_x[is_seen], expected[is_seen], atol=0.5)
    left, bottom, right, top = replay["box"]
    y = 100 * episode.people[:, 0, Y]
    is_in_view = (left < expected) & (expected < right) & (bottom < y) & (y < top)
    assert is_in_view.any()
    assert is_seen[is_in_view].all()
    assert run["end"].startswith("arrived at ")


def test_ways_are_broken_where_somebody_else_takes_the_slot(replays: list[Replay]) -> None:
    episode = next(iter(replays[0].runs.values()))
    people = np.full((12, 1, 5), np.nan)
    people[:4, 0, X] = np.arange(4) * 0.1
    people[4:8, 0, X] = 9.0 + np.arange(4) * 0.1  # a jump
    people[9:, 0, X] = 9.4 + np.arange(3) * 0.1  # after a gap
    people[..., Y] = np.where(np.isnan(people[..., X]), np.nan, 1.0)
    ways = report_places.ways(episode._replace(people=people))
    assert [(way[0, 0], round(way[-1, 0], 6)) for way in ways] == [(0, 0.3), (9.0, 9.3), (9.4, 9.6)]


def test_the_view_holds_the_path_and_grows_for_people_only_so_far() -> None:
    path = np.array([[0.0, 0.0], [12.0, 0.0]])
    low, high = report_places.view(path, [])
    assert (low.tolist(), high.tolist()) == ([-2.0, -2.0], [14.0, 2.0])
    low, high = report_places.view(path, [np.array([[6.0, 50.0], [99.0, 0.0]])])
    assert (low.tolist(), high.tolist()) == ([-2.0, -2.0], [14.0, 4.0])
