"""Places as data, and as arrays for the engines: walls, the robot's path, and people's routes.

    name: my laboratory
    walls: [[-2, 1.2, 14, 1.2], [-2, -1.2, 14, -1.2]]      # x1, y1, x2, y2 in m
    path: {points: [[0, 0], [12, 0]], corner_radius_m: 1.0}
    routes:                                                 # optional, to cross the path
      - {points: [[6, -4], [6, 4]], room_m: 0.4}

Every place has routes along the path, with and against the robot; the routes in the data cross it.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Gt, MinLen
from pydantic import Field

from hazbot_gym.config import Loose, Section
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

Point = Annotated[tuple[float, float], Loose]
Segment = Annotated[tuple[float, float, float, float], Loose]


class CircleData(Section):
    """One counter-clockwise lap of a circle that starts at its lowest point."""

    center: Point
    radius_m: Annotated[float, Gt(0)]


class PathData(Section):
    """The robot's path: a polyline with rounded corners, or a circle."""

    points: Annotated[list[Point], MinLen(2)] | None = None
    corner_radius_m: Annotated[float, Gt(0)] = 1.0
    circle: CircleData | None = None


class RouteData(Section):
    """A way that people walk across the robot's path, and how far they spread to either side."""

    points: Annotated[list[Point], MinLen(2)]
    room_m: Annotated[float, Gt(0)] = 0.4


class PlaceData(Section):
    """A place as a person would write it down."""

    name: str
    walls: tuple[Segment, ...] = Field(default=(), strict=False)  # a list will do
    path: PathData
    routes: tuple[RouteData, ...] = Field(default=(), strict=False)
    along_room_m: Annotated[float, Gt(0)] = 0.7  # lateral room of people along the path
    run_out_m: Annotated[float, Gt(0)] = RUN_OUT_M


def build_place(data: PlaceData) -> Place:
    """Return a place's arrays, after checking that the robot fits through.

    Raises:
        InvalidInput: The path touches a wall, or a route is no way or far from the path.
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
    narrowest_m, where = np.inf, (0.0, 0.0)
    for x, y, *_ in sample_path(path, steps):
        for wall in walls:
            near_x, near_y = nearest_on_segment(x, y, *wall)
            clearance_m = float(np.hypot(x - near_x, y - near_y))
            if clearance_m < narrowest_m:
                narrowest_m, where = clearance_m, (x, y)
    if narrowest_m <= ROBOT_RADIUS_M:
        raise InvalidInput(
            f"place {name}: path passes a wall at {narrowest_m:.2f} m near "
            f"({where[0]:.1f}, {where[1]:.1f}), allowed is more than {ROBOT_RADIUS_M:.2f} m"
        )


def _along(path: Records, run_out_m: float) -> Floats:
    """Return the path as waypoints, straight pieces by their ends, with a run-out at each."""
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
    try:
        route = straight_path(points, 1e-6)
    except ValueError as error:
        raise InvalidInput(
            f"place {name}: routes: given {points.tolist()}, two points in a row must not coincide "
            "and the way must not turn back on itself"
        ) from error
    on_route = np.arange(0.0, path_length(route.view(np.recarray)), 0.05)
    p = sample_path(path, on_path)[:, None, :2]
    q = sample_path(route, on_route)[None, :, :2]
    distance = np.hypot(*np.moveaxis(p - q, -1, 0))
    i, k = np.unravel_index(int(np.argmin(distance)), distance.shape)
    if distance[i, k] > 1.0:
        raise InvalidInput(
            f"place {name}: a route stays {distance[i, k]:.1f} m from the path, allowed is 1 m"
        )
    return float(on_path[i]), float(on_route[k])


def pad_routes(points: list[Floats]) -> Floats:
    """Return waypoint lists of any sizes as one array (R, K, 3) of x, y and arc length [m]."""
    size = max(len(route) for route in points)
    routes = np.empty((len(points), size, 3))
    for row, route in zip(routes, points, strict=True):
        arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(route, axis=0).T)))
        row[: len(route)] = np.column_stack([route, arc])
        row[len(route) :] = row[len(route) - 1]
    return routes
