from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hazbot_gym.evaluation.episode import X, Y
from hazbot_gym.study import replay_records
from hazbot_gym.study.replay_records import Replay, Replays, Sonar, from_rows, rows_of
from hazbot_gym.study.report import maps, page, player


@pytest.fixture(scope="module")
def study(finished: Path) -> page.Study:
    return page.read(finished)


@pytest.fixture(scope="module")
def replays(study: page.Study) -> list[Replay]:
    return study.replays.chosen["Crossing"]


def test_every_policy_drives_through_the_chosen_scenarios(
    study: page.Study, replays: list[Replay]
) -> None:
    for replay in replays:
        assert list(replay.runs) == list(study.config.policies)
        starts = [run.pose[0].tolist() for run in replay.runs.values()]
        assert starts == [starts[0]] * len(starts)
        assert replay.path[0].tolist() == pytest.approx(starts[0][:2], abs=1e-5)
        assert len(replay.walls)
    assert "median" in replays[0].why


def test_what_is_written_is_read(study: page.Study, replays: list[Replay]) -> None:
    beside = replays[0]._replace(best=replays[0].runs["fuzzy_expert"], why="median regret")
    some = Replays({"Crossing": replays}, {"Crossing": beside})
    again = from_rows(pd.DataFrame(list(rows_of(some))))
    assert [each.number for each in again.chosen["Crossing"]] == [each.number for each in replays]
    found = again.beside_best["Crossing"]
    assert (found.why, list(found.runs)) == ("median regret", list(beside.runs))
    assert found.best is not None
    for name, run in {**beside.runs, "fuzzy_expert": beside.best}.items():
        assert run is not None
        np.testing.assert_array_equal(found.runs[name].people, run.people)
        np.testing.assert_array_equal(found.runs[name].pose, run.pose)
        np.testing.assert_array_equal(found.runs[name].ranges_m, run.ranges_m)
        np.testing.assert_array_equal(found.runs[name].earned, run.earned)
        np.testing.assert_array_equal(found.runs[name].contact, run.contact)
        assert found.runs[name].outcome == run.outcome


def test_a_ring_of_any_size_is_read_and_packed(replays: list[Replay]) -> None:
    angles = np.linspace(-1.0, 1.0, 7)
    sonar = Sonar(0.3, 4.0, angles, 0.2 + 0.1 * angles)
    run = replays[0].runs["fuzzy_expert"]
    ranges_m = np.arange(7 * (len(run.time_s) - 1)).reshape(-1, 7) % 400 / 100.0
    kept = replays[0]._replace(sonar=sonar, runs={"a": run._replace(ranges_m=ranges_m)})
    (again,) = from_rows(pd.DataFrame(list(rows_of(Replays({"x": [kept]}, {}))))).chosen["x"]
    assert again.sonar.axes_rad == pytest.approx(sonar.axes_rad, abs=1e-6)
    assert again.sonar.half_cones_rad == pytest.approx(sonar.half_cones_rad, abs=1e-6)
    np.testing.assert_array_equal(again.runs["a"].ranges_m, ranges_m)
    content = json.loads(zlib.decompress(base64.b64decode(player.pack({"x": [again]}))))
    (packed,) = content["sets"]["x"]
    assert len(packed["runs"]["a"]["sonar"]) == len(packed["sonar"]["half_cones"]) == 7


def test_gas_is_read_and_packed_where_there_is_gas(replays: list[Replay]) -> None:
    dry = replays[0].runs["fuzzy_expert"]
    reading = np.linspace(-0.5, 2.0, len(dry.time_s))
    wet = dry._replace(reading=reading, alarm=(reading > 1.0).astype(float))
    leaky = replays[0]._replace(leak=np.array([3.0, -0.5]), runs={"a": wet})
    kept = [replays[0], leaky._replace(number=replays[0].number + 10_000)]
    plain, again = from_rows(pd.DataFrame(list(rows_of(Replays({"x": kept}, {}))))).chosen["x"]
    assert (len(plain.leak), len(plain.runs["fuzzy_expert"].reading)) == (0, 0)
    assert again.leak == pytest.approx([3.0, -0.5])
    np.testing.assert_allclose(again.runs["a"].reading, reading, atol=1e-6)
    content = json.loads(zlib.decompress(base64.b64decode(player.pack({"x": [plain, again]}))))
    without, packed = content["sets"]["x"]
    assert "leak" not in without
    assert not {"reading", "alarm"} & set(without["runs"]["fuzzy_expert"])
    assert packed["leak"] == [300, -50]
    np.testing.assert_allclose(np.cumsum(packed["runs"]["a"]["reading"]), 100 * reading, atol=0.5)
    assert np.cumsum(packed["runs"]["a"]["alarm"]).tolist() == (100 * wet.alarm).tolist()


def test_a_drive_without_people_is_read_as_one(replays: list[Replay]) -> None:
    run = replays[0].runs["fuzzy_expert"]
    alone = run._replace(people=np.empty((len(run.time_s), 0, 5)))
    kept = replays[0]._replace(runs={"a": alone}, walls=np.empty((0, 4)))
    (again,) = from_rows(pd.DataFrame(list(rows_of(Replays({"x": [kept]}, {}))))).chosen["x"]
    assert again.runs["a"].people.shape == (len(run.time_s), 0, 5)
    assert again.walls.shape == (0, 4)


@pytest.mark.parametrize("column", ["scenario_set", "pose", "instants", "sonar", "is_recorded"])
def test_other_rows_are_refused(replays: list[Replay], column: str) -> None:
    rows = pd.DataFrame(list(rows_of(Replays({"Crossing": replays}, {}))))
    with pytest.raises(ValueError, match="replays"):
        from_rows(rows.drop(columns=column))


def test_people_at_instants_beyond_the_end_are_refused(replays: list[Replay]) -> None:
    rows = pd.DataFrame(list(rows_of(Replays({"Crossing": replays}, {}))))
    rows["instants"] = [each + 10**6 for each in rows["instants"]]
    with pytest.raises(ValueError, match="replays"):
        from_rows(rows)


def test_packed_replays_are_the_episodes_to_the_centimetre(replays: list[Replay]) -> None:
    packed = player.pack({"Crossing": replays})
    content = json.loads(zlib.decompress(base64.b64decode(packed)))
    replay = content["sets"]["Crossing"][0]
    policy, run = next(iter(replay["runs"].items()))
    episode = replays[0].runs[policy]
    assert run["dt_s"] == 0.1
    np.testing.assert_allclose(np.cumsum(run["x"]), 100 * episode.pose[:, 0], atol=0.5)
    np.testing.assert_allclose(np.cumsum(run["speed"]), 1000 * episode.speed_mps, atol=0.5)
    np.testing.assert_allclose(np.cumsum(run["earned"]), 100 * episode.earned, atol=0.5)
    sonar_cm = content["sonar_cm"] * np.cumsum(run["sonar"], axis=1).T
    np.testing.assert_allclose(sonar_cm, 100 * episode.ranges_m, atol=content["sonar_cm"] / 2)
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


def test_a_drive_that_was_not_measured_says_so(replays: list[Replay]) -> None:
    runs = {name: run._replace(is_recorded=False) for name, run in replays[0].runs.items()}
    packed = player.pack({"Crossing": [replays[0]._replace(runs=runs)]})
    content = json.loads(zlib.decompress(base64.b64decode(packed)))
    for run in content["sets"]["Crossing"][0]["runs"].values():
        assert "differs" in run["end"]


def test_ways_are_broken_where_somebody_else_takes_the_slot(replays: list[Replay]) -> None:
    episode = next(iter(replays[0].runs.values()))
    people = np.full((12, 1, 5), np.nan)
    people[:4, 0, X] = np.arange(4) * 0.1
    people[4:8, 0, X] = 9.0 + np.arange(4) * 0.1  # a jump
    people[9:, 0, X] = 9.4 + np.arange(3) * 0.1  # after a gap
    people[..., Y] = np.where(np.isnan(people[..., X]), np.nan, 1.0)
    ways = maps.ways(episode._replace(people=people))
    assert [(way[0, 0], round(way[-1, 0], 6)) for way in ways] == [(0, 0.3), (9.0, 9.3), (9.4, 9.6)]


def test_a_picture_has_a_color_for_every_episode(replays: list[Replay]) -> None:
    many = maps.picture(replays * 5, "fuzzy_expert").episodes
    assert list(many) == list(maps.HUES)
    assert all(len(way) > 1 for ways in many.values() for way in ways)
    assert len(maps.picture(replays[:1], "fuzzy_expert").episodes) == 1


def test_the_view_holds_the_path_and_grows_for_people_only_so_far() -> None:
    path = np.array([[0.0, 0.0], [12.0, 0.0]])
    low, high = maps.view(path, [])
    assert (low.tolist(), high.tolist()) == ([-2.0, -2.0], [14.0, 2.0])
    low, high = maps.view(path, [np.array([[6.0, 50.0], [99.0, 0.0]])])
    assert (low.tolist(), high.tolist()) == ([-2.0, -2.0], [14.0, 4.0])


def test_drives_of_very_many_people_are_refused(
    replays: list[Replay], monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = pd.DataFrame(list(rows_of(Replays({"Crossing": replays}, {}))))
    monkeypatch.setattr(replay_records, "MOST_CELLS", 1000)
    with pytest.raises(ValueError, match="1,000"):
        from_rows(rows)
