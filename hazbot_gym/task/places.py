"""Places as data: walls, the robot's path, and the routes that people walk.

Built-in places are functions of a few lengths; a user's place is a YAML file of the same
ingredients:

    name: my laboratory walls: [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]]      # x1, y1, x2, y2 in m
    path: {points: [[0, 0], [12, 0]], corner_radius_m: 1.0} routes:
    # optional; along the path is always there
      - {points: [[6, -4], [6, 4]], room_m: 0.4}

Every place offers routes along the path, with and against the robot; further routes cross it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
import yaml
from annotated_types import Gt, MinLen
from pydantic import BaseModel, ConfigDict, ValidationError

from hazbot_gym.config import first_error
from hazbot_gym.core.geometry import (
    circle_path,
    nearest_on_segment,
    path_length,
    sample_path,
    straight_path,
)
from hazbot_gym.core.state import ACROSS, AGAINST, ALONG, ROBOT_RADIUS_M, Floats, Place, Records
from hazbot_gym.errors import InvalidInput

RUN_OUT_M = 8.0  # people come from, and walk on to, this far beyond the path's ends
ROUTE_STEP_M = 0.5  # spacing of waypoints on a curved route

Point = tuple[float, float]
Segment = tuple[float, float, float, float]


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class CircleData(_Strict):
    """One counter-clockwise lap of a circle that starts at its lowest point."""

    center: Point
    radius_m: Annotated[float, Gt(0)]


class PathData(_Strict):
    """The robot's path: a polyline with rounded corners, or a circle."""

    points: Annotated[list[Point], MinLen(2)] | None = None
    corner_radius_m: Annotated[float, Gt(0)] = 1.0
    circle: CircleData | None = None


class RouteData(_Strict):
    """A way that people walk across the robot's path, and how far they spread to either side."""

    points: Annotated[list[Point], MinLen(2)]
    room_m: Annotated[float, Gt(0)] = 0.4


class PlaceData(_Strict):
    """A place as a person would write it down."""

    name: str
    walls: list[Segment] = []
    path: PathData
    routes: list[RouteData] = []
    along_room_m: Annotated[float, Gt(0)] = 0.7  # lateral room of people along the path
    run_out_m: Annotated[float, Gt(0)] = RUN_OUT_M


# --- built-in places -----------------------------------------------------------------------------


def open_floor(*, length_m: float = 12.0) -> PlaceData:
    """Return a floor without walls and a straight path: the paper's simulations (section 5.2)."""
    return PlaceData(
        name="open", path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]), along_room_m=1.5
    )


def corridor(
    *, width_m: float = 2.4, length_m: float = 12.0, side_door_m: float = 1.6
) -> PlaceData:
    """Return a straight corridor with a door on either side, halfway, through which people cross."""
    half, middle, door = width_m / 2, length_m / 2, side_door_m / 2
    walls: list[Segment] = []
    for y in (-half, half):
        outward = 3.0 if y > 0 else -3.0
        walls += [
            (-RUN_OUT_M, y, middle - door, y),
            (middle + door, y, length_m + RUN_OUT_M, y),
            (middle - door, y, middle - door, y + outward),
            (middle + door, y, middle + door, y + outward),
        ]
    across = half + 2.8
    return PlaceData(
        name="corridor",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        routes=[
            RouteData(points=[(middle, -across), (middle, across)], room_m=door - 0.35),
            RouteData(points=[(middle, across), (middle, -across)], room_m=door - 0.35),
        ],
        along_room_m=half - 0.25,
    )


def intersection(
    *, width_m: float = 2.0, side_width_m: float = 2.0, length_m: float = 12.0
) -> PlaceData:
    """Return a crossing of two corridors whose corners hide who comes."""
    half, side, middle = width_m / 2, side_width_m / 2, length_m / 2
    walls: list[Segment] = []
    for y, far in ((-half, -half - RUN_OUT_M), (half, half + RUN_OUT_M)):
        walls += [
            (-RUN_OUT_M, y, middle - side, y),
            (middle + side, y, length_m + RUN_OUT_M, y),
            (middle - side, y, middle - side, far),
            (middle + side, y, middle + side, far),
        ]
    ends = half + RUN_OUT_M - 0.5
    return PlaceData(
        name="intersection",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        routes=[
            RouteData(points=[(middle, -ends), (middle, ends)], room_m=side - 0.3),
            RouteData(points=[(middle, ends), (middle, -ends)], room_m=side - 0.3),
        ],
        along_room_m=half - 0.25,
    )


def doorway(*, width_m: float = 2.4, door_m: float = 1.2, length_m: float = 12.0) -> PlaceData:
    """Return a corridor with a doorway halfway that lets one person or the robot through at a time."""
    half, middle, door = width_m / 2, length_m / 2, door_m / 2
    return PlaceData(
        name="doorway",
        walls=[
            (-RUN_OUT_M, -half, length_m + RUN_OUT_M, -half),
            (-RUN_OUT_M, half, length_m + RUN_OUT_M, half),
            (middle, -half, middle, -door),
            (middle, door, middle, half),
        ],
        path=PathData(points=[(0.0, 0.0), (length_m, 0.0)]),
        along_room_m=max(door - 0.3, 0.05),
    )


def circle(*, radius_m: float = 3.431) -> PlaceData:
    """Return the paper's circle (Table 3) in an open hall; people walk straight across it."""
    r, reach = radius_m, radius_m + 5.0
    return PlaceData(
        name="circle",
        path=PathData(circle=CircleData(center=(0.0, r), radius_m=r)),
        routes=[
            RouteData(points=[(-reach, 0.5 * r), (reach, 0.5 * r)], room_m=0.6),
            RouteData(points=[(reach, 1.5 * r), (-reach, 1.5 * r)], room_m=0.6),
            RouteData(points=[(0.6 * r, -4.0), (0.6 * r, 2 * r + 4.0)], room_m=0.6),
            RouteData(points=[(-0.6 * r, 2 * r + 4.0), (-0.6 * r, -4.0)], room_m=0.6),
        ],
        along_room_m=0.8,
        run_out_m=0.5,
    )


def aisle(*, width_m: float = 2.2, leg_m: float = 7.0) -> PlaceData:
    """Return an L-shaped aisle between shelves: a blind corner, and shelf ends that narrow the way."""
    half, run = width_m / 2, RUN_OUT_M
    shelf = 0.3  # depth by which a shelf end stands out
    walls: list[Segment] = [
        (-run, -half, leg_m + half, -half),  # outer side
        (leg_m + half, -half, leg_m + half, leg_m + run),
        (-run, half, leg_m - half, half),  # inner side
        (leg_m - half, half, leg_m - half, leg_m + run),
        (0.4 * leg_m, -half, 0.4 * leg_m, -half + shelf),  # shelf ends
        (0.6 * leg_m, -half, 0.6 * leg_m, -half + shelf),
        (0.4 * leg_m, -half + shelf, 0.6 * leg_m, -half + shelf),
        (leg_m - half, 0.6 * leg_m, leg_m - half + shelf, 0.6 * leg_m),
        (leg_m - half, 0.8 * leg_m, leg_m - half + shelf, 0.8 * leg_m),
        (leg_m - half + shelf, 0.6 * leg_m, leg_m - half + shelf, 0.8 * leg_m),
    ]
    return PlaceData(
        name="aisle",
        walls=walls,
        path=PathData(points=[(0.0, 0.0), (leg_m, 0.0), (leg_m, leg_m)], corner_radius_m=1.0),
        along_room_m=half - shelf - 0.25,
    )


PLACES: dict[str, Callable[..., PlaceData]] = {
    "open": open_floor,
    "corridor": corridor,
    "intersection": intersection,
    "doorway": doorway,
    "circle": circle,
    "aisle": aisle,
}


# --- from data to arrays -------------------------------------------------------------------------


def load_place(name: str, options: Mapping[str, float] | None = None) -> Place:
    """Return a built-in place by name, or one from a YAML file, checked and ready for the engines.

    Args:
        name: A name of ``PLACES``, or the path of a ``.yaml`` file.
        options: Lengths of a built-in place, by name [m].

    Raises:
        InvalidInput: The name, an option or the file's content cannot be used.
    """
    if name.endswith((".yaml", ".yml")):
        if options:
            raise InvalidInput("place_options: given, but a place from a file takes none")
        return build_place(_read_place(Path(name)))
    if name not in PLACES:
        allowed = ", ".join(PLACES)
        raise InvalidInput(f"place: given {name!r}, allowed are {allowed} or a .yaml file")
    known = inspect.signature(PLACES[name]).parameters
    for option, value in (options or {}).items():
        if option not in known:
            raise InvalidInput(f"place_options: given {option!r}, {name} takes {', '.join(known)}")
        if not 0.0 < value < 1000.0:
            raise InvalidInput(
                f"place_options.{option}: given {value}, allowed is 0 < length < 1000"
            )
    return build_place(PLACES[name](**(options or {})))


def _read_place(path: Path) -> PlaceData:
    try:
        return PlaceData.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise InvalidInput(f"place: cannot read {path} ({error.strerror})") from error
    except yaml.YAMLError as error:
        raise InvalidInput(f"place: {path} is not YAML ({str(error).splitlines()[0]})") from error
    except ValidationError as error:
        raise InvalidInput(f"place {path}: {first_error(error)}") from error


def build_place(data: PlaceData) -> Place:
    """Return a place's arrays, after checking that the robot fits through.

    Raises:
        InvalidInput: The path touches a wall, or a route never comes near the path.
    """
    walls = np.array(data.walls, dtype=np.float64).reshape(-1, 4)
    path = _path(data)
    _check_path(data.name, walls, path)
    run_out, room = data.run_out_m, data.along_room_m
    along = _along(path, run_out)
    length = path_length(path.view(np.recarray))
    routes = [
        (along, ALONG, (0.0, run_out), room),
        (along[::-1], AGAINST, (length, run_out), room),
    ]
    for route in data.routes:
        points = np.array(route.points, dtype=np.float64)
        routes.append((points, ACROSS, _meeting(data.name, path, points), route.room_m))
    return Place(
        walls=walls,
        path=path,
        routes=pad_routes([points for points, *_ in routes]),
        route_kinds=np.array([kind for _, kind, *_ in routes], dtype=np.int64),
        route_anchors=np.array([anchor for *_, anchor, _ in routes], dtype=np.float64),
        route_rooms=np.array([room for *_, room in routes], dtype=np.float64),
    )


def _path(data: PlaceData) -> Records:
    chosen = data.path
    if (chosen.points is None) == (chosen.circle is None):
        raise InvalidInput(f"place {data.name}: path takes either points or circle")
    if chosen.circle is not None:
        x, y = chosen.circle.center
        return circle_path(x, y - chosen.circle.radius_m, 0.0, chosen.circle.radius_m)
    try:
        return straight_path(np.array(chosen.points), chosen.corner_radius_m)
    except ValueError as error:
        raise InvalidInput(f"place {data.name}: path.points: {error}") from error


def _check_path(name: str, walls: Floats, path: Records) -> None:
    steps = np.arange(0.0, path_length(path.view(np.recarray)) + 0.05, 0.05)
    for x, y, *_ in sample_path(path, steps):
        for wall in walls:
            near_x, near_y = nearest_on_segment(x, y, *wall)
            clearance = float(np.hypot(x - near_x, y - near_y))
            if clearance <= ROBOT_RADIUS_M:
                raise InvalidInput(
                    f"place {name}: path passes a wall at {clearance:.2f} m near ({x:.1f}, {y:.1f}), "
                    f"the robot needs more than {ROBOT_RADIUS_M:.2f} m"
                )


def _along(path: Records, run_out_m: float) -> Floats:
    """Return the path as waypoints, straight pieces by their ends, with a run-out at both ends."""
    length = path_length(path.view(np.recarray))
    marks = [-run_out_m, 0.0]
    for piece in path:
        start, size = float(piece["s"]), float(piece["length"])
        parts = 1 if piece["curvature"] == 0.0 else max(int(np.ceil(size / ROUTE_STEP_M)), 1)
        marks += [start + size * (k + 1) / parts for k in range(parts)]
    return sample_path(path, np.array([*marks, length + run_out_m]))[:, :2]


def _meeting(name: str, path: Records, points: Floats) -> tuple[float, float]:
    """Return the arc lengths on path and route where the two come nearest."""
    on_path = np.arange(0.0, path_length(path.view(np.recarray)), 0.05)
    route = straight_path(points, 1e-6)
    on_route = np.arange(0.0, path_length(route.view(np.recarray)), 0.05)
    p = sample_path(path, on_path)[:, None, :2]
    q = sample_path(route, on_route)[None, :, :2]
    distance = np.hypot(*np.moveaxis(p - q, -1, 0))
    i, k = np.unravel_index(int(np.argmin(distance)), distance.shape)
    if distance[i, k] > 1.0:
        raise InvalidInput(
            f"place {name}: a route stays {distance[i, k]:.1f} m from the path, at most 1 m is allowed"
        )
    return float(on_path[i]), float(on_route[k])


def pad_routes(points: list[Floats]) -> Floats:
    """Return waypoint lists of different sizes as one array (R, K, 3) of x, y and arc length [m]."""
    size = max(len(route) for route in points)
    routes = np.empty((len(points), size, 3))
    for row, route in zip(routes, points, strict=True):
        arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(route, axis=0).T)))
        row[: len(route)] = np.column_stack([route, arc])
        row[len(route) :] = row[len(route) - 1]
    return routes
