from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import yaml

from hazbot_gym.config import make_config
from hazbot_gym.core.geometry import nearest_on_segment, path_length, sample_path
from hazbot_gym.core.state import ACROSS, AGAINST, ALONG, ROBOT_RADIUS_M, Floats, Place
from hazbot_gym.errors import DoubtfulPlace
from hazbot_gym.task.places import PLACES, load_place
from hazbot_gym.task.scenario import ScenarioSampler
from tests.refusals import refused

LENGTHS_M = {"circle": 2.0 * np.pi * 3.431, "aisle": 12.0 + np.pi / 2.0}  # 12 m elsewhere

YARD = {
    "name": "yard",
    "walls": [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]],
    "path": {"points": [[0, 0], [12, 0]]},
    "routes": [{"points": [[6, -4], [6, 4]], "room_m": 0.3}],
    "along_room_m": 0.5,
}


def write(path: Path, content: object) -> str:
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return str(path)


def clearances(points: Floats, walls: Floats) -> Floats:
    """Return each point's distance to the nearest wall [m]."""
    nearest = [
        [np.hypot(*(point - nearest_on_segment(*point, *wall))) for wall in walls]
        for point in points
    ]
    return np.min(nearest, axis=1, initial=np.inf)


def on_path(place: Place, step_m: float = 0.07) -> Floats:
    length = path_length(place.path.view(np.recarray))
    return sample_path(place.path, np.arange(0.0, length, step_m))[:, :2]


@pytest.mark.parametrize("name", PLACES)
def test_robot_fits_through_every_built_in_place(name: str) -> None:
    place = load_place(name)

    assert path_length(place.path.view(np.recarray)) == pytest.approx(LENGTHS_M.get(name, 12.0))
    assert clearances(on_path(place), place.walls).min() > ROBOT_RADIUS_M + 0.2


@pytest.mark.parametrize("name", PLACES)
def test_people_fit_on_their_lanes_in_every_built_in_place(name: str) -> None:
    place = load_place(name)

    for route, room_m in zip(place.routes, place.route_rooms, strict=True):
        for a, b in itertools.pairwise(route[:, :2]):
            t = np.linspace(0.0, 1.0, 50)[:, None]
            assert clearances(a + t * (b - a), place.walls).min() > room_m, "no lane in a wall"


@pytest.mark.parametrize("name", PLACES)
def test_every_place_has_a_way_with_and_a_way_against_the_robot(name: str) -> None:
    place = load_place(name)
    path = on_path(place)

    assert place.route_kinds[:2].tolist() == [ALONG, AGAINST]
    assert (place.route_kinds[2:] == ACROSS).all()
    with_robot, against = place.routes[:2]
    assert np.allclose(with_robot[::-1, :2], against[:, :2])
    for point in path[::10]:
        nearest = min(
            np.hypot(*(point - nearest_on_segment(*point, *a, *b)))
            for a, b in itertools.pairwise(with_robot[:, :2])
        )
        assert nearest < 0.05, "people walk where the robot drives"


@pytest.mark.parametrize("name", PLACES)
def test_anchors_are_where_a_route_meets_the_path(name: str) -> None:
    place = load_place(name)

    for route, (on_path_m, on_route_m) in zip(place.routes, place.route_anchors, strict=True):
        x, y = sample_path(place.path, np.array([on_path_m]))[0, :2]
        arc = route[:, 2]
        is_way = np.append(True, np.diff(arc) > 0.0)
        met = [np.interp(on_route_m, arc[is_way], route[is_way, axis]) for axis in (0, 1)]
        assert met == pytest.approx([x, y], abs=0.06)


def test_lengths_of_a_built_in_place_can_be_chosen() -> None:
    place = load_place("corridor", {"width_m": 3.0, "length_m": 20.0})

    assert path_length(place.path.view(np.recarray)) == 20.0
    assert clearances(on_path(place), place.walls).min() == pytest.approx(1.5)


def test_an_open_floor_may_end_at_a_wall_which_the_path_must_not_touch() -> None:
    place = load_place("open", {"length_m": 8.0, "end_wall_m": 0.4})

    assert clearances(on_path(place), place.walls).min() == pytest.approx(0.4, abs=0.03)
    with refused("wall"):
        load_place("open", {"end_wall_m": 0.2})


def test_place_from_a_file_is_what_the_file_says(tmp_path: Path) -> None:
    place = load_place(write(tmp_path / "yard.yaml", YARD))

    assert place.walls.tolist() == YARD["walls"]
    assert place.route_kinds.tolist() == [ALONG, AGAINST, ACROSS]
    assert place.route_rooms.tolist() == [0.5, 0.5, 0.3]
    assert place.route_anchors[2] == pytest.approx([6.0, 4.0])


@pytest.mark.parametrize(
    ("name", "options", "complaint"),
    [
        ("corridr", {}, "place ... 'corridr' ... open, corridor ... .yaml"),
        ("corridor", {"lenght_m": 9.0}, "place_options ... 'lenght_m' ... corridor ... width_m"),
        ("corridor", {"width_m": -1.0}, "place_options.width_m ... -1.0 ... 0 <"),
        ("corridor", {"width_m": np.inf}, "place_options.width_m ... inf ... 0 <"),
        ("corridor", {"width_m": 0.55}, "corridor ... 0.28 m"),
        ("corridor", {"width_m": 0.4}, "corridor ... along_room_m"),
        ("doorway", {"door_m": 0.5}, "doorway ... 0.25 m"),
        ("aisle", {"leg_m": 0.9}, "aisle"),
        ("no/such/file.yaml", {}, "place ... no/such/file.yaml"),
        ("x.yaml", {"width_m": 2.0}, "place_options ... file"),
    ],
)
def test_impossible_choice_of_a_place_is_one_clear_line(
    name: str, options: dict[str, float], complaint: str
) -> None:
    with refused(complaint):
        load_place(name, options)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"colour": "red"}, "colour ... unknown ... name, walls, path, routes"),
        ({"path": None}, "path ... None"),
        ({"path": {}}, "path ... points ... circle"),
        (
            {"path": {"points": [[0, 0], [1, 0]], "circle": {"center": [0, 0], "radius_m": 1}}},
            "path ... points ... circle",
        ),
        ({"path": {"circle": {"center": [0, 0], "radius_m": 0}}}, "path.circle.radius_m ... 0"),
        ({"path": {"points": [[0, 0]]}}, "path.points"),
        ({"path": {"points": [[0, 0], [0, 0]]}}, "path.points ... point 1 ... point 2"),
        (
            {"path": {"points": [[0, 0], [9, 0], [9, 0.5]]}},
            "path.points ... corner 1 ... 9.0, 0.0 ... 1.0",
        ),
        ({"path": {"points": [[0, 0], [float("nan"), 0]]}}, "path.points.1.0 ... nan"),
        ({"walls": [[0, 0, 1]]}, "walls.0.3"),
        ({"walls": [[6, -1, 6, 1]]}, "wall ... 0.00 m"),
        ({"along_room_m": 0}, "along_room_m ... 0"),
        (
            {"routes": [{"points": [[6, 4], [6, 4]]}]},
            "routes.0.points ... coincide",
        ),
        (
            {"routes": [{"points": [[6, 4], [6, 0], [6, 4]]}]},
            "routes.0.points ... turns back",
        ),
        ({"routes": [{"points": [[6, 4], [7, 3]]}]}, "routes.0 ... 3.0 m"),
        ({"routes": [{"points": [[6, -4], [6, 4]], "rom": 1}]}, "routes.0.rom ... unknown"),
    ],
)
def test_mistake_in_a_place_file_is_one_clear_line(
    tmp_path: Path, change: dict[str, object], complaint: str
) -> None:
    path = write(tmp_path / "yard.yaml", {**YARD, **change})

    with refused(f"place ... yard ... {complaint}"):
        load_place(path)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"walls: [", "YAML"),
        (b"\xff\xfe\xff", "YAML"),
        (b"- 1", "list ... mapping"),
        (b"", "name ... required"),
        (b"name: yard", "path ... required"),
    ],
)
def test_file_that_is_no_place_is_one_clear_line(
    tmp_path: Path, content: bytes, complaint: str
) -> None:
    path = tmp_path / "yard.yaml"
    path.write_bytes(content)

    with refused(f"place ... {complaint}"):
        load_place(str(path))


# --- plausible places ----------------------------------------------------------------------------


def drawn(tmp_path: Path, **change: object) -> str:
    return write(tmp_path / "yard.yaml", {**YARD, **change})


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"path": {"points": [[0, 0], [1200, 0]]}}, "1200 m"),
        ({"path": {"circle": {"center": [0, 0], "radius_m": 1e8}}}, "path"),
        ({"path": {"points": [[0, 0], [0.01, 0]]}}, "0.01 m ... 0.1 to 500 m"),
        ({"path": {"points": [[0, 0], [1e308, 0]]}}, "points.1.0 ... 1e+308"),
        ({"routes": [{"points": [[600, -400], [6, 400]]}]}, "routes.0 ... 996.4 m"),
        ({"walls": [[0, 2, 9, 2], [3, 3, 3, 3]]}, "walls.1"),
        ({"walls": [[0, 2, float("inf"), 2]]}, "walls.0.2 ... inf"),
        ({"routes": [{"points": []}]}, "routes.0.points"),
        ({"run_out_m": 800}, "run_out_m ... 800"),
        (
            {"path": {"points": [[0, 0], [4, 0], [4, 0], [9, 0]]}},
            "path.points ... point 2 ... point 3",
        ),
        (
            {"path": {"points": [[0, 0], [9, 0], [9, 9], [12, 9]], "corner_radius_m": 8}},
            "corner 1 ... 9.0, 0.0 ... corner_radius_m = 8.0 ... point 2 ... point 3",
        ),
    ],
)
def test_implausible_place_is_refused_with_the_figure(
    tmp_path: Path, change: dict[str, object], complaint: str
) -> None:
    with refused(f"place ... yard ... {complaint}"):
        load_place(drawn(tmp_path, **change))


def test_a_door_that_leaves_no_room_for_tracking_errors_is_doubted(tmp_path: Path) -> None:
    door = drawn(tmp_path, walls=[[6, 1.2, 6, 0.31], [6, -1.2, 6, -0.31]])
    with pytest.warns(DoubtfulPlace, match=r"0.31 m near \(6.0, 0.0\)"):
        ScenarioSampler(make_config(place=door))
    wide = drawn(tmp_path, walls=[[6, 1.2, 6, 0.4], [6, -1.2, 6, -0.4]])
    ScenarioSampler(make_config(place=wide))  # a warning would be an error
    with pytest.warns(DoubtfulPlace, match="up to 0.14 m"):
        ScenarioSampler(make_config(place=wide, drive={"nominal_speed_mps": 1.0}))


def test_a_wall_ahead_of_the_end_is_no_narrow_passage() -> None:
    ScenarioSampler(make_config(scenario="C-experiment+wall"))


def test_a_path_longer_than_an_episode_is_doubted(tmp_path: Path) -> None:
    place = drawn(tmp_path, path={"points": [[0, 0], [80, 0]]})
    with pytest.warns(DoubtfulPlace, match=r"80.0 m .*160 s .*120 s"):
        ScenarioSampler(make_config(place=place))
    ScenarioSampler(make_config(place=place, max_episode_steps=1700))
    with pytest.warns(DoubtfulPlace, match="corridor.* 90.0 m"):
        ScenarioSampler(make_config(place_options={"length_m": 90.0}))


def test_a_path_that_only_the_start_makes_too_long_is_doubted(tmp_path: Path) -> None:
    ScenarioSampler(make_config(place=drawn(tmp_path, path={"points": [[0, 0], [59.75, 0]]})))
    place = drawn(tmp_path, path={"points": [[0, 0], [59.9, 0]]})  # 119.7 s at full speed
    with pytest.warns(DoubtfulPlace, match="yard"):
        ScenarioSampler(make_config(place=place))


def test_walls_in_another_unit_than_the_path_are_doubted(tmp_path: Path) -> None:
    place = drawn(tmp_path, walls=[[-200, 120, 1400, 120], [-200, -120, 1400, -120]])
    with pytest.warns(DoubtfulPlace, match="120 m"):
        ScenarioSampler(make_config(place=place))
