from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hazbot_gym.calibration import encounters as model
from hazbot_gym.calibration import price
from hazbot_gym.calibration.encounter_walk import (
    COARSE_M,
    meeting_of,
    model_outcome,
    recorded_outcome,
    stage_of,
)
from hazbot_gym.calibration.encounters import (
    PUBLISHED,
    SHIPPED,
    load_encounters,
    outcomes,
    split,
    staged,
)
from hazbot_gym.calibration.encounters_report import tables
from hazbot_gym.cli import app
from hazbot_gym.core.social_force import Reaction
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M
from hazbot_gym.task.places import load_place
from hazbot_gym.task.track_formats.encounters import read_encounters
from hazbot_gym.utils.files import read_json
from tests.encounter_rows import rows, written
from tests.refusals import refused

RECORD = Path(__file__).parents[2] / "benchmarks" / "encounters.json"
GROUP = ("frontal", "hsr")


@pytest.fixture
def met(tmp_path: Path) -> Path:
    """Return a file with four scenes of one group, a person who passes in each."""
    lines = [
        line for scene in range(1, 5) for line in rows(scene=scene, lateral_m=0.3 + 0.1 * scene)
    ]
    return written(tmp_path / "met.csv", lines)


def test_person_who_ignores_the_robot_walks_as_recorded(met: Path) -> None:
    third = read_encounters(met)[2]
    meeting = meeting_of(third)
    assert meeting is not None
    (walk,) = meeting.walks
    assert walk.pace_mps == pytest.approx(1.2, abs=0.01)
    assert len(walk.waypoints) == 2  # a straight walk
    recorded = recorded_outcome(meeting)
    assert recorded.closest_m == pytest.approx(0.6, abs=0.02)
    assert recorded.slowest == pytest.approx(1.0, abs=0.05)
    stage = stage_of(meeting, load_place("open"))
    force = PUBLISHED.force()._replace(jitter_mps2=0.0)
    walked = model_outcome(stage, force, Reaction(gain=0.0, range_m=0.0), key=0)
    assert walked.closest_m == pytest.approx(recorded.closest_m, abs=0.03)


def test_stronger_response_keeps_people_farther_away(met: Path) -> None:
    encounters = staged(load_encounters(met))
    closest_m = [
        model.summary(
            outcomes(encounters, PUBLISHED._replace(robot_strength_mps2=strength))[GROUP]
        )[1]
        for strength in (0.2, 3.0, 12.0)
    ]
    assert closest_m == sorted(closest_m)
    assert closest_m[-1] > closest_m[0] + 0.1


def test_radius_of_the_robot_is_the_recorded_one(tmp_path: Path) -> None:
    for robot, radius_m in (("hsr", 0.22), ("jackal", 0.27)):
        (recording,) = read_encounters(written(tmp_path / f"{robot}.csv", rows(robot=robot)))
        meeting = meeting_of(recording)
        assert meeting is not None
        person = stage_of(meeting, load_place("open")).people[0]
        assert person["radius"] + ROBOT_RADIUS_M == pytest.approx(radius_m + PERSON_RADIUS_M)


def test_evasion_is_no_waypoint(tmp_path: Path) -> None:
    aside = f",{0.6 + 0.5 * COARSE_M:.3f},"
    evading = [
        line.replace(",0.600,", aside) if 2.0 < float(line.split(",")[5]) < 3.0 else line
        for line in rows()
    ]
    (recording,) = read_encounters(written(tmp_path / "evades.csv", evading))
    meeting = meeting_of(recording)
    assert meeting is not None
    assert len(meeting.walks[0].waypoints) == 2


def test_standing_person_stays(tmp_path: Path) -> None:
    there = ["3.000", "0.700", ""]
    split_lines = [line.split(",") for line in rows()]
    lines = [",".join([*each[:7], *there] if each[6] == "1" else each) for each in split_lines]
    (recording,) = read_encounters(written(tmp_path / "stands.csv", lines))
    meeting = meeting_of(recording)
    assert meeting is not None
    assert meeting.walks[0].pace_mps == 0.0
    assert math.isnan(recorded_outcome(meeting).slowest)


def test_no_scene_is_fitted_on_and_held_out(met: Path) -> None:
    encounters = staged(load_encounters(met))
    for chosen in ((), ("3",)):
        fitted, held_out = split(encounters, chosen)
        assert not set(fitted.scenes) & set(held_out.scenes)
        assert sorted(fitted.scenes + held_out.scenes) == ["1", "2", "3", "4"]
    assert set(split(encounters, ("3",))[0].scenes) == {"3"}


def test_fit_finds_a_response_with_the_same_outcomes(met: Path) -> None:
    encounters = staged(load_encounters(met)).of(["1", "3"])
    made = outcomes(encounters, PUBLISHED._replace(robot_range_m=0.5, noticed_m=3.0))
    found = model.fit(encounters, made, seed=0)
    assert model.loss(encounters, found, made) < 0.2 * model.loss(encounters, PUBLISHED, made)


def test_gains_are_spread_around_one() -> None:
    assert {each.gain for each in PUBLISHED.reactions()} == {1.0}
    gains = [each.gain for each in PUBLISHED._replace(gain_spread=0.5).reactions()]
    assert gains == sorted(gains)
    assert gains[len(gains) // 2] == pytest.approx(1.0)
    assert gains[0] * gains[-1] == pytest.approx(1.0)


def test_report_has_every_group_on_both_sides(met: Path) -> None:
    fitted, held_out = split(staged(load_encounters(met)))
    record = model.report(fitted, held_out, PUBLISHED)
    assert [row["fitted_on"] for row in record["groups"]] == [True, False]
    for row, encounters in zip(record["groups"], (fitted, held_out), strict=True):
        assert row["encounters"] == len(encounters.stages)
        assert row["model"] == row["published"]
        off = max(abs(a - b) for a, b in zip(row["model"][:3], row["recorded"][:3], strict=True))
        assert row["largest_difference_m"] == pytest.approx(off)
        low, high = row["recorded_intervals"][1]
        assert low <= row["recorded"][1] <= high


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("standing", ["robot", "1"])
def test_statistics_of_what_stands_are_missing(tmp_path: Path, standing: str) -> None:
    """A standing robot reveals no price, and a standing person has no slowest speed."""
    lines = [
        ",".join([*cells[:7], "1.000", "0.600", *cells[9:]] if cells[6] == standing else cells)
        for scene, behaviour in enumerate(("compliant", "noncompliant"))
        for cells in (line.replace("compliant", behaviour).split(",") for line in rows(scene=scene))
    ]
    recordings = load_encounters(written(tmp_path / "met.csv", lines))
    record = model.report(*split(staged(recordings), ("0",)), PUBLISHED)
    record["price"] = price.report(price.drives_of(recordings))
    tables(record)
    json.dumps(record, allow_nan=False)
    assert (record["price"] is None) == (standing == "robot")
    assert (record["groups"][0]["recorded"][3] is None) == (standing == "1")


@pytest.mark.parametrize(
    ("fit", "named"),
    [(("5",), "fit ... '5' ... 1, 2, 3, 4"), (("1", "2", "3", "4"), "fit ... all")],
)
def test_unusable_split_is_refused(met: Path, fit: tuple[str, ...], named: str) -> None:
    with refused(named):
        split(staged(load_encounters(met)), fit)


def test_file_without_encounters_is_refused(tmp_path: Path) -> None:
    lines = [f"{frame},1,{0.1 * frame:.1f},0.0" for frame in range(30)]
    walk = written(tmp_path / "walk.csv", lines, head="frame,id,x,y\n")
    (tmp_path / "walk.json").write_text('{"fps": 10, "units": "m"}')
    result = CliRunner().invoke(app, ["calibrate", "--encounters", str(walk)])
    assert result.exit_code == 2
    assert "encounter" in result.output


def test_record_is_the_evaluation_of_its_response(tracks_dir: Path) -> None:
    record = read_json(RECORD)
    fitted, held_out = split(staged(load_encounters(tracks_dir / "robot_encounters" / "dev.csv")))
    found = model.report(fitted, held_out, model.Response(**record["response"]))
    for side, loss in record["loss"].items():
        assert found["loss"][side] == pytest.approx(loss)
    for row, kept in zip(found["groups"], record["groups"], strict=True):
        assert row["model"] == pytest.approx(kept["model"])


def test_the_environments_have_the_fitted_response() -> None:
    fitted = read_json(RECORD)["response"]
    shipped = {**SHIPPED._asdict(), "gain_spread": fitted["gain_spread"]}
    assert shipped == fitted
    assert fitted["gain_spread"] < 0.05  # one response for all attentive people
