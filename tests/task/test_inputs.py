"""The files a result depends on: every one that was read, and no other."""

from pathlib import Path

from hazbot_gym.config import make_config
from hazbot_gym.task.inputs import input_files
from tests.refusals import refused

TWO_SIGHTINGS = "id,frame,x,y\n1,0,0,0\n1,10,0.5,0\n"


def test_built_in_places_and_the_synthetic_recording_read_no_file() -> None:
    assert input_files(make_config(place="aisle")) == []
    assert input_files(make_config(people={"model": "replay"})) == []


def test_a_place_file_is_an_input(tmp_path: Path) -> None:
    place = tmp_path / "lab.yaml"
    place.write_text("name: lab\npath: {points: [[0, 0], [9, 0]]}\n")
    assert input_files(make_config(place=str(place))) == [place]


def test_recordings_and_their_descriptions_are_inputs(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    for table in (tmp_path / "hall.csv", tmp_path / "below" / "yard.csv"):
        table.write_text(TWO_SIGHTINGS)
    (tmp_path / "hall.json").write_text('{"fps": 25}')
    (tmp_path / "notes.md").write_text("not a recording")
    config = make_config(people={"model": "seeded"}, tracks=str(tmp_path))
    assert set(input_files(config)) == {
        tmp_path / "hall.csv",
        tmp_path / "hall.json",
        tmp_path / "below" / "yard.csv",
    }


def test_only_the_files_that_are_read_are_inputs(tmp_path: Path) -> None:
    tracks = str(tmp_path / "nowhere")  # social-force people need no tracks
    assert input_files(make_config(place="corridor", tracks=tracks)) == []
    with refused("no such file"):
        input_files(make_config(people={"model": "replay"}, tracks=tracks))
