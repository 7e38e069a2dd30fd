from __future__ import annotations

import json
from pathlib import Path

import pytest

from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_formats import Given, UnknownFormat, read_table
from tests.refusals import refused

SCENE = '{"scene": {"id": 0, "p": 1, "s": 0, "e": 120, "fps": 2.5, "tag": 2}}\n'


def track(frame: int, person: int = 1, x: float = 0.0, **more: object) -> str:
    return json.dumps({"track": {"f": frame, "p": person, "x": x, "y": 1.5, **more}}) + "\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "walk.ndjson"
    path.write_text(text)
    return path


def test_rate_counts_rows_and_frames_go_up_in_steps(tmp_path: Path) -> None:
    rows = "".join(track(10 + 6 * k, p, 0.5 * k) for k in range(21) for p in (1, 2))
    recording = read_tracks(written(tmp_path, SCENE + rows))

    assert recording.people == 2
    assert recording.dt_s == pytest.approx(0.4)
    assert recording.positions[1].tolist() == [0.5, 1.5]
    assert recording.reading is not None
    assert recording.reading[:4] == ("TrajNet++", "format", "m", "format")
    assert (recording.reading.fps, recording.reading.fps_from) == (15.0, "scenes")


def test_predictions_are_left_out(tmp_path: Path) -> None:
    rows = track(0) + track(6) + track(6, x=3.0, prediction_number=0, scene_id=0)
    table = read_table(written(tmp_path, SCENE + "\n" + rows))

    assert table.frames.tolist() == [0, 6]
    assert table.notes == ("1 predicted positions are left out",)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (SCENE, "is empty"),
        (SCENE + track(0) + "{nonsense\n", "line 3 ... JSON"),
        (SCENE + "[" * 100_000, "line 2 ... JSON"),
        (SCENE + track(0) + track(0), "line 3 ... already"),
        (SCENE + '{"track": {"f": 0, "p": 1, "x": "a", "y": 0}}', "line 2 ... x"),
        (SCENE + '{"track": {"f": 0, "p": 1, "x": 0}}', "line 2 ... y ... None"),
        (SCENE + '{"track": {"f": true, "p": 1, "x": 0, "y": 0}}', "line 2 ... f"),
        (SCENE + f'{{"track": {{"f": 1{"0" * 400}, "p": 1, "x": 0, "y": 0}}}}', "large"),
        (SCENE + track(0, x=float("nan")), "line 2 ... finite"),
        (SCENE + SCENE.replace("2.5", "25") + track(0), "fps"),
        (SCENE.replace("2.5", "true") + track(0), "fps"),
        (SCENE.replace("2.5", '"a"') + track(0), "fps"),
        (SCENE.replace("2.5", "[1]") + track(0), "fps"),
    ],
)
def test_every_fault_is_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    with refused(complaint):
        read_table(written(tmp_path, text))


def test_other_lines_are_another_format(tmp_path: Path) -> None:
    for other in ('{"id": 1, "x": 2}\n', '{"track": 3}\n'):
        with refused("line 1", error=UnknownFormat):
            read_table(written(tmp_path, other))


def test_columns_have_names_already(tmp_path: Path) -> None:
    with refused("columns"):
        read_table(written(tmp_path, SCENE + track(0)), Given(columns=("id",)))
