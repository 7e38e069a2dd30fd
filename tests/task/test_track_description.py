from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.task.track_description import read_description
from tests.refusals import refused


def written(folder: Path, text: str) -> Path:
    path = folder / "walk.json"
    path.write_text(text)
    return path


def test_fields_that_are_not_known_are_left_alone(tmp_path: Path) -> None:
    known = {"name": "a", "fps": 25, "units": "cm", "columns": "id frame x y", "license": "CC0"}
    others = {
        **{"set": "s", "split": "dev", "kind": "k", "frame_step": 1, "dt_s": 0.04, "n_people": 2},
        **{"robot_id": None, "n_rows": 9, "frames": [1, 2], "duration_s": 1.0, "x_range": [0, 1]},
        **{"notes": "n", "doi": None, "licence_evidence": []},
        "geometry": {"corridor_width_m": 3.0, "walkable_polygon": [], "geometry_source": ""},
        "source": {"path": "p", "original_format": "o", "original_unit": "m", "sha256": "0"},
    }
    found = read_description(written(tmp_path, json.dumps(known | others)))

    assert (found.name, found.fps, found.units, found.licence) == ("a", 25.0, "cm", "CC0")
    assert str(found.source) == "p"


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        *(("unit", "units"), ("Units", "units"), ("FPS", "fps"), ("framerate", "fps")),
        *(("frame_rate", "fps"), ("frame-rate", "fps"), ("column", "columns"), ("names", "name")),
        *(("scale", "metres_per_pixel"), ("meters_per_pixel", "metres_per_pixel")),
        *(("licenses", "license"), ("geometri", "geometry"), ("sources", "source")),
    ],
)
def test_misspelled_field_is_refused(tmp_path: Path, name: str, meant: str) -> None:
    with refused(f"walk.json ... '{name}' ... '{meant}'"):
        read_description(written(tmp_path, json.dumps({name: "m"})))


def test_misspelled_field_of_the_place_is_refused(tmp_path: Path) -> None:
    with refused("'wall' ... 'walls'"):
        read_description(written(tmp_path, '{"geometry": {"wall": []}}'))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("fps = 10", "walk.json ... JSON"),
        ("[" * 100_000, "walk.json ... JSON"),
        ("[]", "walk.json"),
        ('{"fps": 25, "fps": 16}', "walk.json ... 'fps'"),
        ('{"fps": 0}', "walk.json ... fps ... greater than 0"),
        ('{"fps": "25"}', "walk.json ... fps ... number"),
        ('{"fps": true}', "walk.json ... fps ... number"),
        ('{"fps": NaN}', "walk.json ... fps"),
        ('{"fps": Infinity}', "walk.json ... fps"),
        ('{"fps": 1e999}', "walk.json ... fps"),
        ('{"units": "km"}', "walk.json ... units ... 'm', 'cm', 'mm' or 'px'"),
        ('{"metres_per_pixel": -1}', "walk.json ... metres_per_pixel ... greater"),
        ('{"geometry": {"walls": [[1, 2, 3, 4]]}}', "walk.json ... geometry.walls.0"),
        ('{"geometry": {"walls": [[[0, NaN], [1, 1]]]}}', "walk.json ... geometry.walls.0.0.1"),
        (
            '{"geometry": {"walls": [[[0, 0], [1e308, 1]]]}}',
            "geometry.walls.0.1.0",
        ),
        ('{"geometry": {"corridor_x": [0, -Infinity]}}', "walk.json ... geometry.corridor_x.1"),
        ('{"geometry": {"corridor_axis": "z"}}', "walk.json ... geometry.corridor_axis"),
    ],
)
def test_every_fault_is_one_line(tmp_path: Path, text: str, complaint: str) -> None:
    with refused(complaint):
        read_description(written(tmp_path, text))


def test_description_that_is_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "walk.json").mkdir()

    with refused("walk.json"):
        read_description(tmp_path / "walk.json")


def test_without_a_file_nothing_is_said(tmp_path: Path) -> None:
    empty: dict[str, Any] = read_description(tmp_path / "none.json").model_dump(exclude_unset=True)
    assert empty == {}
