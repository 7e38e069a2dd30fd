from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.geometry import (
    circle_path,
    clip,
    is_in_sight,
    may_be_near,
    nearest_on_segment,
    norm,
    path_length,
    path_pose,
    route_pose,
    sample_path,
    segments_cross,
    straight_path,
    wrap_angle,
)
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.state import Floats, Records

LENGTHS = st.floats(-20.0, 20.0)
POINTS = st.tuples(LENGTHS, LENGTHS)
SEGMENTS = st.tuples(LENGTHS, LENGTHS, LENGTHS, LENGTHS)

L_PATH = straight_path(np.array([[0.0, 0.0], [7.0, 0.0], [7.0, 7.0]]), 1.0)
Z_PATH = straight_path(np.array([[0.0, 0.0], [4.0, 0.0], [6.0, -3.0], [12.0, -3.0]]), 0.8)
PATHS = {"L": L_PATH, "Z": Z_PATH, "circle": circle_path(1.0, 2.0, 0.5, 3.431)}


@given(st.floats(-1e6, 1e6))
def test_wrapped_angle_is_the_same_direction_in_the_half_open_turn(angle: float) -> None:
    wrapped = wrap_angle(angle)

    assert -math.pi < wrapped <= math.pi
    turns = (angle - wrapped) / (2.0 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)


@pytest.mark.parametrize(
    ("angle", "expected"),
    [
        (0.0, 0.0),
        (math.pi, math.pi),
        (-math.pi, math.pi),
        (3.0 * math.pi, math.pi),
        (math.nextafter(math.pi, 4.0), -math.pi),
        (-1.5 * math.pi, 0.5 * math.pi),
    ],
)
def test_half_a_turn_is_positive(angle: float, expected: float) -> None:
    assert wrap_angle(angle) == pytest.approx(expected, abs=1e-15)
    assert wrap_angle(angle) > -math.pi


def test_clip_holds_a_value_between_its_bounds() -> None:
    assert [clip(value, -1.0, 2.0) for value in (-3.0, 0.5, 7.0)] == [-1.0, 0.5, 2.0]


@given(POINTS)
def test_norm_is_the_length_of_a_vector(point: tuple[float, float]) -> None:
    assert norm(*point) == pytest.approx(math.hypot(*point), rel=1e-12, abs=1e-150)


@given(POINTS, SEGMENTS)
def test_no_point_of_a_segment_is_nearer_than_the_nearest(
    point: tuple[float, float], segment: tuple[float, float, float, float]
) -> None:
    x, y = nearest_on_segment(*point, *segment)
    x1, y1, x2, y2 = segment
    t = np.linspace(0.0, 1.0, 101)
    others = np.hypot(x1 + t * (x2 - x1) - point[0], y1 + t * (y2 - y1) - point[1])

    assert math.dist((x, y), point) <= others.min() + 1e-9
    on_segment = math.dist((x, y), (x1, y1)) + math.dist((x, y), (x2, y2))
    assert on_segment == pytest.approx(math.dist((x1, y1), (x2, y2)), abs=1e-6)


@pytest.mark.parametrize(
    ("wall", "expected"),
    [
        ((2.0, -1.0, 2.0, 1.0), True),
        ((2.0, 0.0, 2.0, 1.0), True),  # the wall's end touches
        ((2.0, 0.1, 2.0, 1.0), False),
        ((5.0, -1.0, 5.0, 1.0), False),  # beyond the end
        ((4.0, -1.0, 4.0, 1.0), False),  # who stands at a wall is not behind it
        ((1.0, 0.0, 3.0, 0.0), False),  # along the line of sight
    ],
)
def test_line_of_sight_ends_at_walls_between(
    wall: tuple[float, float, float, float], expected: bool
) -> None:
    walls = np.array([(0.0, 9.0, 9.0, 9.0), wall])

    assert segments_cross(0.0, 0.0, 4.0, 0.0, *wall) is expected
    assert is_in_sight(0.0, 0.0, 4.0, 0.0, walls) is not expected
    assert is_in_sight(4.0, 0.0, 0.0, 0.0, walls) is not expected


@pytest.mark.parametrize("name", PATHS)
def test_path_is_continuous_and_walked_at_unit_speed(name: str) -> None:
    path, step = PATHS[name], 1e-3
    length = path_length(path.view(np.recarray))
    x, y, heading, curvature = sample_path(path, np.arange(-1.0, length + 1.0, step)).T

    turn = np.diff(heading)
    speed = np.hypot(np.diff(x), np.diff(y)) / step
    course = np.arctan2(np.diff(y), np.diff(x)) - (heading[:-1] + 0.5 * turn)
    assert speed == pytest.approx(np.ones_like(speed), abs=1e-6)
    assert np.abs((course + math.pi) % (2.0 * math.pi) - math.pi).max() < 2e-3
    assert np.abs(turn - step * curvature[:-1]).max() < 2e-3 * np.abs(curvature).max()


@given(st.lists(POINTS, min_size=2, max_size=5), st.floats(0.01, 1.0))
def test_any_polyline_is_a_path_between_its_ends_or_refused(
    points: list[tuple[float, float]], radius_m: float
) -> None:
    try:
        path = straight_path(np.array(points), radius_m)
    except ValueError:
        return
    length = path_length(path.view(np.recarray))
    ends = sample_path(path, np.array([0.0, length]))
    polyline_m = sum(math.dist(a, b) for a, b in itertools.pairwise(points))

    assert ends[:, :2] == pytest.approx(np.array([points[0], points[-1]]), abs=1e-6)
    assert length <= polyline_m + 1e-9
    joints = path["s"][1:]
    before, after = sample_path(path, joints - 1e-9), sample_path(path, joints)
    assert after[:, :3] == pytest.approx(before[:, :3], abs=1e-6)


def test_corner_is_rounded_to_its_radius() -> None:
    assert L_PATH["length"] == pytest.approx([6.0, math.pi / 2.0, 6.0])
    assert L_PATH["curvature"] == pytest.approx([0.0, 1.0, 0.0])
    middle = sample_path(L_PATH, np.array([6.0 + math.pi / 4.0]))[0]
    root = math.sqrt(0.5)
    assert middle == pytest.approx([6.0 + root, 1.0 - root, math.pi / 4.0, 1.0])
    assert Z_PATH["curvature"][[1, 3]] == pytest.approx([-1.25, 1.25])  # right, then left


def test_beyond_its_ends_a_path_goes_straight_on() -> None:
    x, y, heading, curvature = sample_path(PATHS["circle"], np.array([-2.0]))[0]
    assert (x, y) == pytest.approx((1.0 - 2.0 * math.cos(0.5), 2.0 - 2.0 * math.sin(0.5)))
    assert (heading, curvature) == (0.5, 0.0)

    beyond = sample_path(L_PATH, np.array([12.0 + math.pi / 2.0 + 3.0]))[0]
    assert beyond == pytest.approx([7.0, 10.0, math.pi / 2.0, 0.0])


def test_circle_ends_where_it_began_after_a_turn_to_the_left() -> None:
    path = PATHS["circle"]
    length = path_length(path.view(np.recarray))
    poses = sample_path(path, np.array([0.0, length / 4.0, length]))

    assert poses[2, :2] == pytest.approx(poses[0, :2])
    assert poses[:, 2] == pytest.approx([0.5, 0.5 + math.pi / 2.0, 0.5 + 2.0 * math.pi])
    assert poses[:, 3] == pytest.approx(np.full(3, 1.0 / 3.431))


@pytest.mark.parametrize(
    ("points", "radius_m", "complaint"),
    [
        ([[0.0, 0.0]], 1.0, "at least two points"),
        ([[0.0, 0.0], [0.0, 0.0]], 1.0, "coincide"),
        ([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 1.1, "too large"),
        (
            [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]],
            0.1,
            r"corner 1 at \[1.0, 0.0\] turns back on itself",
        ),
    ],
)
def test_impossible_polyline_is_refused(
    points: list[list[float]], radius_m: float, complaint: str
) -> None:
    with pytest.raises(ValueError, match=complaint):
        straight_path(np.array(points), radius_m)


@pytest.mark.parametrize("padding", [0, 1, 3])
@pytest.mark.parametrize(
    ("s", "expected"),
    [
        (-1.0, (-1.0, 0.0, 1.0, 0.0)),
        (2.0, (2.0, 0.0, 1.0, 0.0)),
        (5.5, (4.5, 2.0, 0.6, 0.8)),
        (8.0, (6.0, 4.0, 0.6, 0.8)),
        (13.0, (9.0, 8.0, 0.6, 0.8)),  # straight on
    ],
)
def test_route_is_walked_by_its_waypoints_however_its_row_is_padded(
    padding: int, s: float, expected: tuple[float, ...]
) -> None:
    waypoints = [[0.0, 0.0, 0.0], [3.0, 0.0, 3.0], [6.0, 4.0, 8.0]]
    routes = np.array([[[9.0, 9.0, 0.0]] * (3 + padding), waypoints + waypoints[-1:] * padding])

    assert route_pose(routes, 1, s) == pytest.approx(expected)


@kernel
def compiled_poses(path: Records, routes: Floats, s: Floats, out: Floats) -> None:
    for i in range(s.shape[0]):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = path_pose(path, s[i])
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = route_pose(routes, 0, s[i])
        out[i, 8] = wrap_angle(s[i])


def test_compiled_code_agrees_with_python() -> None:
    routes = np.array([[[0.0, 0.0, 0.0], [3.0, 0.0, 3.0], [6.0, 4.0, 8.0], [6.0, 4.0, 8.0]]])
    s = np.linspace(-3.0, 20.0, 200)
    out = np.empty((200, 9))
    compiled_poses(Z_PATH, routes, s, out)

    assert out[:, :4] == pytest.approx(sample_path(Z_PATH, s), abs=1e-12)
    assert out[:, 4:8] == pytest.approx(np.array([route_pose(routes, 0, value) for value in s]))
    assert out[:, 8] == pytest.approx([wrap_angle(value) for value in s], abs=1e-12)


@given(POINTS, POINTS, POINTS, st.floats(0.0, 3.0))
def test_a_segment_within_reach_is_never_ruled_out(
    point: tuple[float, float], start: tuple[float, float], end: tuple[float, float], reach: float
) -> None:
    nearest = nearest_on_segment(*point, *start, *end)
    if math.dist(point, nearest) <= reach - 1e-9:
        assert may_be_near(*point, *start, *end, reach)


def test_a_segment_far_off_is_ruled_out() -> None:
    assert not may_be_near(0.0, 0.0, 2.0, -5.0, 2.0, 5.0, 1.9)
    assert may_be_near(0.0, 0.0, 2.0, -5.0, 2.0, 5.0, 2.0)
