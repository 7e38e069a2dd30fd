"""Walls from WKT and from maps of ROS: where they stand, in meters."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image

from hazbot_gym.config import make_config
from hazbot_gym.task.inputs import input_files
from hazbot_gym.task.places import load_place
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.task.wall_files import read_walls
from tests.refusals import refused

SQUARE = {(0.0, 0.0, 6.0, 0.0), (6.0, 0.0, 6.0, 4.0), (0.0, 4.0, 6.0, 4.0), (0.0, 0.0, 0.0, 4.0)}
MAP = {
    "image": "map.pgm",
    "resolution": 0.1,
    "origin": [-1.0, -2.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}

MANY = "LINESTRING (0 0" + "".join(f", {k} {k % 2}" for k in range(1, 6001)) + ")"


def ends(walls: list[tuple[float, ...]], digits: int = 9) -> set[tuple[float, ...]]:
    """Return walls as a set, whichever way round they are given."""
    pairs = [sorted([wall[:2], wall[2:]]) for wall in walls]
    return {tuple(round(float(v), digits) + 0.0 for end in pair for v in end) for pair in pairs}


def wkt(tmp_path: Path, text: str) -> list[tuple[float, ...]]:
    path = tmp_path / "floor.wkt"
    path.write_text(text, encoding="utf-8")
    return read_walls(path)


def ros(tmp_path: Path, pixels: np.ndarray, **change: object) -> list[tuple[float, ...]]:
    given = {**MAP, **change}
    Image.fromarray(pixels.astype(np.uint8)).save(tmp_path / str(given["image"]))
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(given), encoding="utf-8")
    return read_walls(tmp_path / "map.yaml")


def block(occupied: int = 0, free: int = 254) -> np.ndarray:
    """Return an image 40 wide and 30 high with a block 10 wide and 20 high, 5 from the bottom."""
    pixels = np.full((30, 40), free)
    pixels[5:25, 10:20] = occupied
    return pixels


def corners(x1: float, y1: float, x2: float, y2: float) -> set[tuple[float, ...]]:
    return {(x1, y1, x2, y1), (x2, y1, x2, y2), (x1, y2, x2, y2), (x1, y1, x1, y2)}


@pytest.mark.parametrize(
    "text",
    [
        "POLYGON ((0 0, 6 0, 6 4, 0 4, 0 0))",
        "LINESTRING (0 0, 6 0, 6 0, 6 4, 0 4, 0 0)",
        "MULTILINESTRING ((0 0, 6 0, 6 4),\n (0 0, 0 4, 6 4))",
        "POLYGON Z ((0 0 1, 6 0 1, 6 4 1, 0 4 1, 0 0 1))\n",
    ],
)
def test_a_square_room_has_its_four_walls(tmp_path: Path, text: str) -> None:
    assert ends(wkt(tmp_path, text)) == SQUARE


def test_holes_and_several_geometries_are_walls(tmp_path: Path) -> None:
    room = "POLYGON ((0 0, 6 0, 6 4, 0 4, 0 0), (1 1, 2 1, 2 2, 1 2, 1 1))"
    walls = wkt(tmp_path, f"{room}\n\nLINESTRING (3 1, 3 2)\n")
    assert ends(walls) == SQUARE | corners(1, 1, 2, 2) | {(3.0, 1.0, 3.0, 2.0)}


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "0 walls ... 1 to"),
        ("POLYGON EMPTY", "0 walls"),
        ("POINT (1 2)", "Point ... polygons and lines"),
        ("LINESTRING (0 0, 6 0)\nPOLYGO ((0 0))", "line 2 ... WKT"),
        ("LINESTRING (0 0, inf 0)", "finite"),
        (MANY, "6000 walls"),
    ],
)
def test_a_bad_wkt_is_one_clear_line(tmp_path: Path, text: str, complaint: str) -> None:
    with refused(f"walls ... {complaint}"):
        wkt(tmp_path, text)


def test_a_block_of_a_map_stands_where_origin_and_resolution_put_it(tmp_path: Path) -> None:
    # 10 to 20 pixels from the left, and 5 to 25 from the bottom, of 0.1 m, from (-1, -2).
    assert ends(ros(tmp_path, block())) == corners(0.0, -1.5, 1.0, 0.5)


def test_rows_of_an_image_go_downwards(tmp_path: Path) -> None:
    pixels = np.full((30, 40), 254)
    pixels[0:2, :] = 0  # the top two rows are the northernmost
    assert ends(ros(tmp_path, pixels, origin=[0, 0, 0])) == corners(0.0, 2.8, 4.0, 3.0)


def test_a_yaw_turns_the_map_about_its_origin(tmp_path: Path) -> None:
    walls = ros(tmp_path, block(), origin=[5.0, 1.0, math.pi / 2])
    # (u, v) in the map is (5 - v, 1 + u): u of 1 to 2 m, v of 0.5 to 2.5 m.
    assert ends(walls) == corners(2.5, 2.0, 4.5, 3.0)


def test_negate_and_threshold_are_honored(tmp_path: Path) -> None:
    assert ends(ros(tmp_path, block(254, 0), negate=1)) == corners(0.0, -1.5, 1.0, 0.5)
    gray = block(occupied=102)  # p = 0.6
    assert ends(ros(tmp_path, gray, occupied_thresh=0.59)) == corners(0.0, -1.5, 1.0, 0.5)
    with refused("0 walls"):
        ros(tmp_path, gray, occupied_thresh=0.61)


def test_a_color_png_is_read_by_the_mean_of_its_channels(tmp_path: Path) -> None:
    rgb = np.repeat(block()[..., None], 3, axis=2)
    assert ends(ros(tmp_path, rgb, image="map.png")) == corners(0.0, -1.5, 1.0, 0.5)


def test_a_pole_of_one_cell_keeps_its_four_sides(tmp_path: Path) -> None:
    pixels = np.full((30, 40), 254)
    pixels[29, 10] = 0
    assert ends(ros(tmp_path, pixels, origin=[0, 0, 0])) == corners(1.0, 0.0, 1.1, 0.1)


def test_a_diagonal_wall_is_few_segments_near_the_cells(tmp_path: Path) -> None:
    pixels = np.full((200, 200), 254)
    for k in range(198):
        pixels[k : k + 3, k] = 0
    walls = np.array(ros(tmp_path, pixels, origin=[0, 0, 0]))
    assert len(walls) < 10
    off = (walls[:, [0, 2]] + walls[:, [1, 3]] - 19.85) / math.sqrt(2)  # of its middle line
    assert np.abs(off).max() < 0.3


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"resolution": 0}, "resolution ... 0"),
        ({"origin": [0, 0]}, "origin.2"),
        ({"mode": "raw"}, "mode ... 'raw'"),
        ({"occupied_thresh": float("nan")}, "occupied_thresh ... nan"),
        ({"negate": 3}, "negate ... 3"),
    ],
)
def test_a_bad_map_is_one_clear_line(
    tmp_path: Path, change: dict[str, object], complaint: str
) -> None:
    with refused(f"walls ... {complaint}"):
        ros(tmp_path, block(), **change)


def test_a_map_of_speckles_is_refused_at_once(tmp_path: Path) -> None:
    with refused("walls ... occupied cells"):
        ros(tmp_path, 254 * (np.indices((500, 1000)).sum(axis=0) % 2))


def test_a_missing_or_damaged_image_is_one_clear_line(tmp_path: Path) -> None:
    ros(tmp_path, block())
    for damage in (Path.unlink, lambda file: file.write_bytes(b"P5\n9 9\n255\n1")):
        damage(tmp_path / "map.pgm")
        with refused("walls ... image"):
            read_walls(tmp_path / "map.yaml")


@pytest.mark.parametrize("walls", ["floor.wkt", "map.yaml"])
def test_a_place_file_names_its_walls_beside_it(tmp_path: Path, walls: str) -> None:
    wkt(tmp_path, "POLYGON ((-1 -1, 9 -1, 9 1, -1 1, -1 -1))")
    ros(tmp_path, block(), origin=[0, 2, 0])
    lab = tmp_path / "lab.yaml"
    lab.write_text(f"name: lab\nwalls: {walls}\npath: {{points: [[0, 0], [8, 0]]}}\n")
    config = make_config(place=str(lab))

    assert len(ScenarioSampler(config).draw(0).place.walls) == 4
    image = [tmp_path / "map.pgm"] if walls == "map.yaml" else []
    assert input_files(config) == [lab, tmp_path / walls, *image]


@pytest.mark.parametrize(
    ("walls", "complaint"),
    [
        ("nowhere.wkt", "walls ... nowhere.wkt"),
        ("floor.dxf", "walls ... 'floor.dxf' ... .wkt"),
    ],
)
def test_walls_that_cannot_be_read_are_one_clear_line(
    tmp_path: Path, walls: str, complaint: str
) -> None:
    lab = tmp_path / "lab.yaml"
    lab.write_text(f"name: lab\nwalls: {walls}\npath: {{points: [[0, 0], [8, 0]]}}\n")
    with refused(complaint):
        load_place(str(lab))


def test_a_file_of_walls_alone_is_no_place(tmp_path: Path) -> None:
    ros(tmp_path, block())
    with refused("map.yaml ... path"):
        load_place(str(tmp_path / "map.yaml"))
    with refused("floor.wkt ... .yaml"):
        load_place("floor.wkt")
