from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.tracks import Corridor
from tests.refusals import refused

WALK = "frame,id,x,y\n" + "".join(f"{10 + k},1,{0.1 * k:.1f},0\n" for k in range(19))  # 1 m/s


def written(folder: Path, text: str, name: str = "walk.csv", **description: Any) -> Path:
    path = folder / name
    path.write_text(text)
    if description:
        path.with_suffix(".json").write_text(json.dumps(description))
    return path


def test_description_gives_name_time_and_place(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        WALK,
        name="walk.csv",
        **{"fps": 10, "units": "m", "licence": "CC0", "citation": "A", "doi": None},
        source={"repo": "a/b", "commit": "c0", "path": "d.txt", "sha256": "0"},
        geometry={
            "corridor_axis": "x",
            "corridor_x": [0, 8],
            "corridor_y": [-1, 1],
            "walls": [[[0, 1], [8, 1]], [[0, -1], [8, -1]]],
        },
    )

    recording = read_tracks(path)

    assert recording.name == "walk"
    assert recording.dt_s == pytest.approx(0.1)
    assert recording.corridor == Corridor("x", (0.0, 8.0), (-1.0, 1.0))
    assert recording.walls.tolist() == [[0, 1, 8, 1], [0, -1, 8, -1]]
    assert (recording.source, recording.licence) == ("a/b c0 d.txt", "CC0")
    assert recording.first_steps.tolist() == [0]
    assert recording.positions[:, 0] == pytest.approx(0.1 * np.arange(19))


def test_frame_rate_comes_from_argument_description_or_comment(tmp_path: Path) -> None:
    described = written(tmp_path, WALK, "a.csv", fps=10)
    commented = written(tmp_path, "# framerate: 12.5 fps\n" + WALK, "b.csv")

    assert read_tracks(described).dt_s == pytest.approx(0.1)
    assert read_tracks(described, fps=20).dt_s == pytest.approx(0.05)
    assert read_tracks(commented).dt_s == pytest.approx(0.08)


def test_frames_that_are_left_out_for_all_make_a_longer_step(tmp_path: Path) -> None:
    every_tenth = "".join(f"{k} 1 {0.04 * k} 0\n{k} 2 0 0\n" for k in range(5, 105, 10))
    path = written(tmp_path, "# frame id x y\n" + every_tenth, "walk.txt")

    assert read_tracks(path, fps=25).dt_s == pytest.approx(0.4)
    assert read_tracks(path, fps=25).lengths.tolist() == [10, 10]


@pytest.mark.parametrize("unit", ["m", "cm", "mm"])
@pytest.mark.parametrize("how", ["magnitude", "description", "option", "comment"])
def test_unit_is_recognised_or_told(tmp_path: Path, unit: str, how: str) -> None:
    scale = {"m": 1, "cm": 100, "mm": 1000}[unit]
    rows = "".join(f"1 {k} {0.1 * k * scale} {scale}\n" for k in range(19))
    head = f"# id frame x/{unit} y/{unit}\n" if how == "comment" else ""
    description = {"units": unit} if how == "description" else {}
    path = written(tmp_path, head + rows, "walk.txt", **description)

    recording = read_tracks(path, fps=10, units=unit if how == "option" else None)

    assert recording.positions[-1] == pytest.approx([1.8, 1.0])


def test_short_gap_is_filled_and_long_one_makes_two_people(tmp_path: Path) -> None:
    frames = [0, 1, 2, 7, 8, 14, 15]  # gaps of 0.5 and 0.6 s
    rows = "".join(f"4 {k} {0.1 * k} {0.2 * k}\n" for k in frames)
    path = written(tmp_path, "".join(f"3 {k} 0 0\n" for k in range(3, 6)) + rows, "walk.txt")

    recording = read_tracks(path, fps=10, units="m")

    assert recording.ids.tolist() == [3, 4, 4]
    assert recording.first_steps.tolist() == [3, 0, 14]
    assert recording.lengths.tolist() == [3, 9, 2]
    assert recording.tracks()[1] == pytest.approx(np.outer(np.arange(9), [0.1, 0.2]))
    assert recording.tracks()[2][:, 0] == pytest.approx([1.4, 1.5])


@pytest.mark.parametrize(
    ("options", "description", "complaint"),
    [
        ({}, {}, "walk.csv ... fps"),
        ({"fps": -1}, {}, "fps ... -1 ... positive number"),
        ({"fps": 10, "units": "km"}, {}, "units ... 'km' ... m, cm, mm, px"),
        ({"fps": 600}, {"units": "m"}, "60 m/s"),
        (
            {"fps": 10, "metres_per_pixel": 0},
            {},
            "metres_per_pixel ... 0",
        ),
        ({"fps": 10, "metres_per_pixel": 1e308}, {}, "metres_per_pixel ... 1e+308"),
        ({}, {"fps": 10, "metres_per_pixel": 1e308}, "walk.json: metres_per_pixel: Input should"),
        ({"fps": 1e308}, {}, "fps ... 1e+308 ... positive number, 1e-06"),
        ({"fps": float("nan")}, {}, "fps ... nan ... positive number"),
        (
            {"fps": 10, "units": "px"},
            {},
            "walk.csv ... pixels",
        ),
        (
            {"fps": 10, "metres_per_pixel": 0.05},
            {"units": "cm"},
            "walk.csv ... metres_per_pixel ... cm",
        ),
        ({"fps": 10, "columns": "frame id x"}, {}, "walk.csv ... columns ... 'frame id x'"),
        (
            {"fps": 10},
            {"geometry": {"corridor_axis": "x", "corridor_x": [1, 0], "corridor_y": [0, 1]}},
            "walk.json ... corridor",
        ),
    ],
)
def test_what_cannot_be_used_is_refused(
    tmp_path: Path, options: dict[str, Any], description: dict[str, Any], complaint: str
) -> None:
    path = written(tmp_path, WALK, **description)

    with refused(complaint):
        read_tracks(path, **options)


def test_single_frame_is_no_recording(tmp_path: Path) -> None:
    path = written(tmp_path, "# id frame x y\n0 0 0 0\n1 0 1 1\n", "walk.txt")

    with refused("walk.txt ... one frame"):
        read_tracks(path, fps=10)


@pytest.mark.parametrize(
    ("original", "table", "fps"),
    [("uo-050-180-180.txt", "uo-050-180-180.csv", 16), ("zara01_obsmat.txt", "zara01.csv", 25)],
)
def test_originals_agree_with_the_tables_made_from_them(
    tracks_dir: Path, original: str, table: str, fps: int
) -> None:
    from_original = read_tracks(tracks_dir / "original" / original, fps=fps)
    from_table = read_tracks(next(tracks_dir.rglob(table)))

    assert from_original.dt_s == from_table.dt_s
    assert np.array_equal(from_original.ids, from_table.ids)
    assert np.array_equal(from_original.first_steps, from_table.first_steps)
    assert np.array_equal(from_original.lengths, from_table.lengths)
    assert np.abs(from_original.positions - from_table.positions).max() < 1e-3


CROWD = "frame,id,x,y\n" + "".join(  # 1.25 m/s at 2.5 Hz
    f"{10 * k},{p},{0.5 * k},{p}\n" for k in range(40) for p in (1, 2, 3)
)


def test_frame_id_x_y_without_names_is_not_taken_for_id_frame_x_y(tmp_path: Path) -> None:
    rows = CROWD.split("\n", 1)[1].replace(",", "\t")
    recording = read_tracks(written(tmp_path, rows, "walk.txt", fps=25))

    assert (recording.people, recording.dt_s) == (3, 0.4)
    assert recording.tracks()[1][-1].tolist() == [19.5, 2.0]
    assert recording.reading is not None
    assert recording.reading.form == "frame id x y"
    assert recording.reading.form_from == "recognized from the values"


def test_reading_says_what_was_used_and_where_it_came_from(tmp_path: Path) -> None:
    described = written(tmp_path, CROWD, "a.csv", fps=25)
    by_json = read_tracks(described).reading
    by_option = read_tracks(described, fps=25, units="m", columns="frame id x y").reading

    assert by_json is not None
    assert by_json[:6] == (
        *("frame id x y", "names in the file", "m", "guess: people walk"),
        *(25.0, "json"),
    )
    assert by_json.speed_mps == pytest.approx(1.25)
    assert by_option is not None
    assert by_option[:6] == ("frame id x y", "option", "m", "option", 25, "option")


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"fps": 250}, "unit ... 12.5 m/s in m, 0.125 m/s in cm"),
        ({"fps": 2.5}, "unit ... 0.125 m/s in m"),
        ({"fps": 25, "units": "mm"}, "0.0013 m/s"),
        ({"fps": 250, "units": "m"}, "12 m/s"),
    ],
)
def test_unit_in_which_people_would_not_walk_is_never_guessed(
    tmp_path: Path, options: dict[str, Any], complaint: str
) -> None:
    with refused(complaint):
        read_tracks(written(tmp_path, CROWD), **options)


def test_latitude_and_longitude_are_refused(tmp_path: Path) -> None:
    rows = "".join(f"{k},1,{50.9 + 1e-6 * k},{6.4 + 1e-6 * k}\n" for k in range(100))
    path = written(tmp_path, "frame,id,x,y\n" + rows)

    for units in ("m", None):
        with refused("walk.csv"):
            read_tracks(path, fps=10, units=units)


def test_one_person_who_only_stands_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "frame,id,x,y\n" + "".join(f"{k},1,2,3\n" for k in range(50)))

    with refused("walk.csv ... 0 m/s"):
        read_tracks(path, fps=10, units="m")


def test_pixels_become_metres_by_the_scale(tmp_path: Path) -> None:
    rows = "".join(f'7 {k} 100 {k + 8} 120 {k} 0 0 0 "Pedestrian"\n' for k in range(60))
    path = written(tmp_path, rows, "annotations.txt")

    with refused("annotations.txt ... pixels ... metres_per_pixel"):
        read_tracks(path, fps=30)
    recording = read_tracks(path, fps=30, metres_per_pixel=0.04)
    assert recording.positions[0].tolist() == pytest.approx([4 * 0.04, 110 * 0.04])
    assert recording.reading is not None
    assert (recording.reading.unit, recording.reading.unit_from) == ("px", "format")


def test_columns_and_scale_can_be_told_beside_the_file(tmp_path: Path) -> None:
    rows = "".join(f"{k} 1 {25 * k} 0 9\n" for k in range(20))
    words = {"columns": ["frame", "id", "x", "y", "-"], "metres_per_pixel": 0.04, "units": "px"}
    recording = read_tracks(written(tmp_path, rows, "walk.txt", fps=1, **words))

    assert recording.positions[:2].tolist() == [[0, 0], [1, 0]]


@pytest.mark.parametrize(
    ("rows", "fps", "complaint"),
    [
        ("0,1,0,0\n1,1,0.1,0\n1000000000000000,2,0,0\n", 10, "1000000000000001"),
        (
            "".join(f"{100_003 * k + k % 7},{k % 2},{0.05 * k},0\n" for k in range(60)),
            1e6,
            "60 ... 11600",
        ),
    ],
)
def test_frames_that_would_fill_the_memory_are_refused(
    tmp_path: Path, rows: str, fps: float, complaint: str
) -> None:
    with refused(complaint):
        read_tracks(written(tmp_path, "frame,id,x,y\n" + rows), fps=fps, units="m")


def test_rate_of_the_file_that_another_overrules_is_a_note(tmp_path: Path) -> None:
    path = written(tmp_path, "# framerate: 25\n" + CROWD)

    reading = read_tracks(path, fps=30).reading
    assert reading is not None
    assert reading.notes == ("fps is 30 (option), but its comment says 25",)
