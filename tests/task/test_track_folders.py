from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.errors import DoubtfulRecording
from hazbot_gym.task import track_folders
from hazbot_gym.task.track_folders import find_recordings, load_tracks, read_all
from tests.refusals import refused

WALK = "".join(f"{k},1,{0.1 * k:.1f},0\n" for k in range(30))  # 1 m/s
NAMED = "# framerate: 10\nframe,id,x,y\n" + WALK
FASTER = "# framerate: 10\nframe,id,x,y\n" + WALK.replace(".", ".5")


def written(folder: Path, text: str, name: str, **description: Any) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    if description:
        path.with_suffix(".json").write_text(json.dumps(description))
    return path


def test_originals_are_not_found_twice(tmp_path: Path) -> None:
    written(tmp_path, NAMED, "a.csv", source={"original_file": "original/a_obsmat.txt"})
    written(tmp_path, NAMED, "b.csv", source={"original_file": "b.csv"})  # itself
    written(tmp_path, NAMED, "c.csv").with_suffix(".json").write_text("{")
    for name in ("original/a_obsmat.txt", "original/b.txt", "other/original/a_obsmat.txt"):
        written(tmp_path, FASTER, name)
    written(tmp_path, "How to walk\n", "README.txt")
    written(tmp_path, "1 0 0\n0 1 0\n0 0 1\n", "homography.txt")

    found = [path.relative_to(tmp_path).as_posix() for path in find_recordings(tmp_path)]

    assert found == ["a.csv", "b.csv", "c.csv", "original/b.txt", "other/original/a_obsmat.txt"]


def test_no_recording_of_a_folder_is_missing_and_each_has_its_own_name(tmp_path: Path) -> None:
    names = ("a/obsmat.txt", "b/obsmat.csv", "c/OBSMAT.TXT", "d/e/deep.tsv", "top.txt")
    for rate, name in enumerate(names, 10):  # different ones, so that none is a copy
        rows = WALK.replace(",", "\t") if name.endswith("tsv") else WALK
        head = "frame\tid\tx\ty" if name.endswith("tsv") else "frame,id,x,y"
        written(tmp_path, f"# framerate: {rate}\n{head}\n{rows}", name)

    found = read_all(tmp_path)

    assert [each.name for each in found.recordings] == [
        *("a/obsmat.txt", "b/obsmat.csv", "OBSMAT", "deep", "top"),
    ]
    assert found.faults == []


def test_texts_of_other_formats_are_found_as_well(tmp_path: Path) -> None:
    rows = "".join(f"2020-01-01T00:00:0{k}Z p1 {k} 0\n" for k in range(9))
    written(tmp_path, "time track x y\n" + rows, "walk.txt")
    written(tmp_path, '{"track": {"f": 0, "p": 1, "x": 0, "y": 0}}\n', "ndjson.txt")
    written(tmp_path, "This is no table of 4 columns.\n", "README.txt")

    assert [path.name for path in find_recordings(tmp_path)] == ["ndjson.txt", "walk.txt"]
    assert read_all(tmp_path / "walk.txt").recordings[0].dt_s == 1.0


def test_names_in_descriptions_are_told_apart_as_well(tmp_path: Path) -> None:
    for name, text in (("a.csv", NAMED), ("b.csv", FASTER)):
        written(tmp_path, text, name).with_suffix(".json").write_text('{"name": "plaza"}')

    assert [each.name for each in load_tracks(tmp_path)] == ["a.csv", "b.csv"]


def test_linked_folders_are_searched_once(tmp_path: Path) -> None:
    written(tmp_path / "elsewhere", NAMED, "a.csv")
    (tmp_path / "tracks").mkdir()
    (tmp_path / "tracks" / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "tracks" / "loop").symlink_to(tmp_path / "tracks")

    assert [path.name for path in find_recordings(tmp_path / "tracks")] == ["a.csv"]


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    with refused("no recordings"):
        find_recordings(tmp_path)
    with refused("nope.csv"):
        find_recordings(tmp_path / "nope.csv")
    path = written(tmp_path, NAMED, "walk.csv")
    assert find_recordings(path) == [path]


def test_file_of_another_kind_in_a_folder_is_a_warning(tmp_path: Path) -> None:
    written(tmp_path, NAMED, "walk.csv")
    other = written(tmp_path, "sample,rater,score\n1,a,3\n", "ratings.csv")

    with pytest.warns(DoubtfulRecording, match="ratings.csv"):
        assert [each.name for each in load_tracks(tmp_path)] == ["walk"]
    with refused("ratings.csv ... unknown format"):
        load_tracks(other)


def test_faults_of_all_files_are_said(tmp_path: Path) -> None:
    written(tmp_path, NAMED, "walk.csv")
    written(tmp_path, "frame,id,x,y\n1,2,3\n", "bad.csv")
    written(tmp_path, "frame,id,x,y\n1,2,3,a\n", "worse.csv")

    with refused("bad.csv ... ; worse.csv"):
        load_tracks(tmp_path)


def test_same_people_in_two_files_are_refused(tmp_path: Path) -> None:
    written(tmp_path, NAMED, "walk.csv")
    written(tmp_path, NAMED.replace("0.3,", "0.305,"), "walk_in_cm_precision.csv")

    with refused("walk_in_cm_precision ... walk"):
        load_tracks(tmp_path)


def test_improbable_recording_is_a_warning_where_it_is_loaded(tmp_path: Path) -> None:
    path = written(tmp_path, "frame,id,x,y\n" + WALK, "walk.csv", units="m", fps=1.0)

    with pytest.warns(DoubtfulRecording, match="walk.* 0.10 m/s"):
        load_tracks(path)


def test_every_real_recording_is_read_once(tracks_dir: Path) -> None:
    found = read_all(tracks_dir)
    names = [recording.name for recording in found.recordings]

    assert found.faults == []
    assert len(names) == len(set(names)) >= 8
    assert all("not read" in doubt for doubt in found.doubts)
    for recording in found.recordings:
        assert recording.people == len(np.unique(recording.ids)), "no track was split"
        assert recording.licence or recording.robot  # encounters have no description


def test_real_folder_without_its_descriptions_needs_them(tracks_dir: Path, tmp_path: Path) -> None:
    shutil.copy(next(tracks_dir.rglob("zara01_obsmat.txt")), tmp_path)

    with refused("fps"):
        load_tracks(tmp_path)


def test_a_whole_disk_is_refused_before_it_is_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b", "c"):
        written(tmp_path, NAMED, f"{name}/walk.csv")
    monkeypatch.setattr(track_folders, "MOST_FOLDERS", 3)
    with refused("3 folders"):
        find_recordings(tmp_path)


def test_what_is_no_file_is_never_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.txt")  # whoever opens it waits for ever
    written(tmp_path, NAMED, "walk.csv")
    assert [path.name for path in find_recordings(tmp_path)] == ["walk.csv"]
    with refused("pipe.txt"):
        find_recordings(tmp_path / "pipe.txt")


def test_folder_that_cannot_be_listed_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, NAMED, "walk.csv")
    (tmp_path / "hidden").mkdir()
    scandir = os.scandir

    def denied(path: str) -> Any:
        if Path(path).name == "hidden":
            raise PermissionError(13, "Permission denied", path)
        return scandir(path)

    monkeypatch.setattr(os, "scandir", denied)
    with refused("hidden ... Permission denied"):
        find_recordings(tmp_path)
