from __future__ import annotations

import warnings
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.geometry import path_length, path_pose
from hazbot_gym.errors import DoubtfulRecording
from hazbot_gym.task.encounter_place import encounter_place, simplified
from hazbot_gym.task.encounter_statistics import encounter_statistics
from hazbot_gym.task.recorded import recorded_places, recorded_table
from hazbot_gym.task.track_folders import load_tracks, read_all
from hazbot_gym.task.track_formats.encounters import is_encounters, read_encounters
from hazbot_gym.task.tracks import RecordedRobot
from tests.encounter_rows import HEAD, rows, written
from tests.envs.test_parity import TOLERANCE, compare, pair
from tests.refusals import refused

NAMES = ("frontal-hsr-compliant-1.1", "frontal-jackal-compliant-2.7")
WALK = "frame,id,x,y\n" + "".join(f"{k},1,{0.1 * k:.1f},0\n" for k in range(30))


@pytest.fixture
def two(tmp_path: Path) -> Path:
    """Return a file with an encounter of each robot."""
    lines = rows() + rows(scene=2, encounter=7, robot="jackal", lateral_m=0.9)
    return written(tmp_path / "met.csv", lines)


def test_each_encounter_is_a_recording_with_its_robot(two: Path) -> None:
    assert is_encounters(two)
    first, second = read_encounters(two)
    assert (first.name, second.name) == (
        "frontal-hsr-compliant-1.1",
        "frontal-jackal-compliant-2.7",
    )
    assert first.robot is not None
    assert second.robot is not None
    assert (first.robot.radius_m, second.robot.radius_m) == (0.22, 0.27)
    assert (first.people, first.dt_s, first.duration_s) == (1, 0.1, pytest.approx(5.9))
    inside = slice(5, -5)  # the average of five samples keeps a straight line, but for its ends
    assert first.robot.positions[inside, 0] == pytest.approx(0.05 * np.arange(60)[inside])
    assert first.positions[inside, 0] == pytest.approx(6.0 - 0.12 * np.arange(60)[inside])


def test_closest_approach_and_speeds_there(two: Path) -> None:
    hsr, jackal = encounter_statistics(load_tracks(two))
    assert hsr.closest_m == pytest.approx((0.6, 0.6, 0.6), abs=0.01)
    assert jackal.closest_m == pytest.approx((0.9, 0.9, 0.9), abs=0.01)
    assert (hsr.robot_mps, hsr.person_mps) == pytest.approx((0.5, 1.2), abs=0.01)


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        (
            "1,frontal,hsr,compliant,1,0.00,robot,0.000",
            "1,frontal,hsr,compliant,1,0.00,robot,x",
            "x_m",
        ),
        ("compliant,1,0.10,1,", "compliant,1,nan,1,", "t_s"),
        ("compliant,1,0.10,1,", "compliant,1,0.13,1,", "t_s"),
        ("compliant,1,0.30,1,", "compliant,1,0.20,1,", "agent 1"),
        ("1,frontal,hsr,compliant,1,0.50", "1,crossing,hsr,compliant,1,0.50", "scenario"),
        (",hsr,", ",rosie,", "'rosie'"),
        (",robot,", ",other,", "'robot'"),
        (",1,5.", ",robot,5.", "agent robot"),
    ],
)
def test_unusable_value_is_one_line(tmp_path: Path, old: str, new: str, named: str) -> None:
    text = "\n".join(rows())
    assert old in text
    path = written(tmp_path / "met.csv", text.replace(old, new).split("\n"))
    with refused(f"met.csv ... {named}"):
        read_encounters(path)


def test_robot_of_another_kind_brings_its_radius(tmp_path: Path) -> None:
    head = HEAD.strip() + ",robot_radius_m\n"
    path = written(tmp_path / "met.csv", [f"{row},0.4" for row in rows(robot="rosie")], head)
    (recording,) = read_encounters(path)
    assert recording.robot is not None
    assert recording.robot.radius_m == 0.4


def test_place_is_the_way_that_the_robot_drove(two: Path) -> None:
    recordings = load_tracks(two)
    places = recorded_places(recordings, with_entries=False)
    table = recorded_table(recordings, 0.05)
    assert table.ways.tolist() == [[0, 0], [1, 1]]
    assert table.recording_of_place.tolist() == [0, 1]
    path = places[0].path.view(np.recarray)
    assert path_length(path) == pytest.approx(0.5 * 5.9, abs=0.1)
    assert path_pose(path, 1.0)[1] == pytest.approx(0.0, abs=1e-6)


def test_corners_of_a_way_stay_and_its_wobble_does_not() -> None:
    x = np.linspace(0.0, 5.0, 200)
    there = np.column_stack([x, 0.05 * np.sin(8.0 * x)])
    up = np.column_stack([np.full(200, 5.0), np.linspace(0.0, 4.0, 200)])
    driven = np.concatenate([there, up])
    assert simplified(driven, 0.15) == pytest.approx(np.array([[0, 0], [5, 0], [5, 4]]), abs=0.1)
    robot = RecordedRobot("hsr", 0.22, "corner", "compliant", "1", driven)
    length_m = path_length(encounter_place("corner", robot).path.view(np.recarray))
    assert 8.0 < length_m < 9.1  # the corner is rounded
    with refused("1 m"):
        encounter_place("still", robot._replace(positions=driven[:30]))


def test_encounters_do_not_mix_with_other_recordings(two: Path) -> None:
    (two.parent / "walk.csv").write_text("# framerate: 10\n" + WALK)
    assert len(read_all(two.parent).recordings) == 3
    with pytest.warns(DoubtfulRecording, match="2 encounters"):
        (recording,) = load_tracks(two.parent)
    assert recording.robot is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(load_tracks(two)) == 2


@pytest.mark.parametrize("model", ["replay", "seeded"])
def test_policy_chooses_the_speed_on_the_recorded_way(two: Path, model: str) -> None:
    env = gymnasium.make(
        "hazbot_gym/Replay-v1", tracks=str(two), people={"model": model}, max_episode_steps=150
    )
    for seed in range(4):
        _, info = env.reset(seed=seed)
        assert info["place"] in NAMES
        assert info["time_free_s"] == pytest.approx(2.95 / 0.5, abs=1.5)
        for _ in range(150):
            *_, terminated, truncated, info = env.step(np.ones(1))
            if terminated or truncated:
                break
        assert info["outcome"] == "arrived"
    env.close()


def test_real_encounters_come_as_near_as_their_table_says(tracks_dir: Path) -> None:
    path = tracks_dir / "robot_encounters" / "dev.csv"
    if not path.exists():
        pytest.skip("recorded encounters are not here")
    found = {(each.scenario, each.robot): each for each in encounter_statistics(load_tracks(path))}
    assert sum(each.encounters for each in found.values()) == 272
    assert found["frontal", "hsr"].closest_m == pytest.approx((0.43, 0.51, 0.63), abs=0.01)
    assert found["crossing", "jackal"].closest_m == pytest.approx((0.44, 0.68, 1.03), abs=0.01)


@pytest.mark.parametrize("model", ["replay", "seeded"])
def test_both_engines_play_an_encounter_alike(two: Path, model: str) -> None:
    worst, ends = compare(
        *pair(2, tracks=str(two), people={"model": model}, max_episode_steps=150), seed=3
    )
    assert worst <= TOLERANCE
    assert ends
