from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_files import find_recordings, read_tracks
from hazbot_gym.task.tracks import Corridor

WALK = "frame,id,x,y\n" + "".join(f"{10 + k},1,{0.1 * k:.1f},0\n" for k in range(9))  # 1 m/s


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
    assert recording.positions[:, 0] == pytest.approx(0.1 * np.arange(9))


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
    rows = "".join(f"1 {k} {0.1 * k * scale} {scale}\n" for k in range(9))
    head = f"# id frame x/{unit} y/{unit}\n" if how == "comment" else ""
    description = {"units": unit} if how == "description" else {}
    path = written(tmp_path, head + rows, "walk.txt", **description)

    recording = read_tracks(path, fps=10, unit=unit if how == "option" else None)

    assert recording.positions[-1] == pytest.approx([0.8, 1.0])


def test_short_gap_is_filled_and_long_one_makes_two_people(tmp_path: Path) -> None:
    frames = [0, 1, 2, 7, 8, 14, 15]  # gaps of 0.5 and 0.6 s
    rows = "".join(f"4 {k} {0.1 * k} {0.2 * k}\n" for k in frames)
    path = written(tmp_path, "".join(f"3 {k} 0 0\n" for k in range(3, 6)) + rows, "walk.txt")

    recording = read_tracks(path, fps=10, unit="m")

    assert recording.ids.tolist() == [3, 4, 4]
    assert recording.first_steps.tolist() == [3, 0, 14]
    assert recording.lengths.tolist() == [3, 9, 2]
    assert recording.tracks()[1] == pytest.approx(np.outer(np.arange(9), [0.1, 0.2]))
    assert recording.tracks()[2][:, 0] == pytest.approx([1.4, 1.5])


@pytest.mark.parametrize(
    ("options", "description", "complaint"),
    [
        ({}, {}, "walk.csv: fps is missing"),
        ({"fps": -1}, {}, "walk.csv: fps must be a positive number, given -1"),
        ({"fps": 10, "unit": "km"}, {}, "unit must be one of m, cm, mm, given 'km'"),
        ({"fps": 600}, {"units": "m"}, "one step in ten is faster than 60 m/s"),
        ({}, {"fps": 0}, "walk.json: fps: Input should be greater than 0"),
        (
            {"fps": 10},
            {"geometry": {"walls": [[1, 2, 3, 4]]}},
            "walk.json: geometry.walls.0: Tuple",
        ),
        (
            {"fps": 10},
            {"geometry": {"corridor_axis": "x", "corridor_x": [1, 0], "corridor_y": [0, 1]}},
            "walk.json: a corridor must reach from less to more",
        ),
    ],
)
def test_what_cannot_be_used_is_refused(
    tmp_path: Path, options: dict[str, Any], description: dict[str, Any], complaint: str
) -> None:
    path = written(tmp_path, WALK, **description)

    with pytest.raises(InvalidInput) as caught:
        read_tracks(path, **options)

    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_description_that_is_not_json_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, WALK)
    path.with_suffix(".json").write_text("fps = 10")

    with pytest.raises(InvalidInput, match=r"walk\.json: Invalid JSON"):
        read_tracks(path)


def test_single_frame_is_no_recording(tmp_path: Path) -> None:
    path = written(tmp_path, "0 0 0 0\n1 0 1 1\n", "walk.txt")

    with pytest.raises(InvalidInput, match="nobody is seen in more than one frame"):
        read_tracks(path, fps=10)


def test_originals_are_not_found_twice(tmp_path: Path) -> None:
    rows = "1 0 0 0\n1 1 0.1 0\n"
    (tmp_path / "original").mkdir()
    written(tmp_path, WALK, "a.csv", source={"original_file": "original/a_obsmat.txt"})
    written(tmp_path, WALK, "b.csv", source="by hand")
    written(tmp_path, WALK, "c.csv").with_suffix(".json").write_text("{")
    written(tmp_path, rows, "original/a_obsmat.txt")
    written(tmp_path, rows, "original/b.txt")
    written(tmp_path, rows, "original/d.txt")
    written(tmp_path, "How to walk\n", "README.txt")
    written(tmp_path, "1 0 0\n0 1 0\n0 0 1\n", "homography.txt")

    found = [path.name for path in find_recordings(tmp_path)]

    assert found == ["a.csv", "b.csv", "c.csv", "d.txt"]


def test_single_file_is_found_and_an_empty_folder_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="no recordings"):
        find_recordings(tmp_path)
    path = written(tmp_path, WALK)
    assert find_recordings(path) == [path]


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


def test_every_real_recording_is_read_once(tracks_dir: Path) -> None:
    recordings = [read_tracks(path) for path in find_recordings(tracks_dir)]

    assert len({recording.name for recording in recordings}) == len(recordings)
    for recording in recordings:
        assert recording.people == len(np.unique(recording.ids)), "no track was split"
        assert recording.licence
