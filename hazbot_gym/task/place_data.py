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
from annotated_types import Gt, Le, MinLen
from pydantic import Field

from hazbot_gym.config.section import Loose, Section
from hazbot_gym.core.geometry import (
    circle_path,
    path_length,
    sample_path,
    straight_path,
)
from hazbot_gym.core.state import ACROSS, AGAINST, ALONG, ROBOT_RADIUS_M, Floats, Place, Records
from hazbot_gym.errors import InvalidInput

RUN_OUT_M = 8.0  # extension of people's routes beyond the path's ends
SHORTEST_PATH_M, LONGEST_PATH_M = 0.1, 500.0  # 12 m in centimeters exceed this
ROUTE_STEP_M = 0.5  # spacing of waypoints on a curved route

Point = Annotated[tuple[float, float], Loose]
Segment = Annotated[tuple[float, float, float, float], Loose]
Room = Annotated[float, Gt(0), Le(100)]


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
    """A route of people across the robot's path, and its lateral spread."""

    points: Annotated[list[Point], MinLen(2)]
    room_m: Room = 0.4


class PlaceData(Section):
    """Description of a place in a YAML file."""

    name: str
    walls: tuple[Segment, ...] = Field(default=(), strict=False)  # a list is accepted
    path: PathData
    routes: tuple[RouteData, ...] = Field(default=(), strict=False)
    along_room_m: Room = 0.7  # lateral room of people along the path
    run_out_m: Annotated[float, Gt(0), Le(100)] = RUN_OUT_M


def build_place(data: PlaceData) -> Place:
    """Return a place's arrays, after a check of the robot's clearance.

    Raises:
        InvalidInput: The path touches a wall, has no plausible length, or a route has no length or
            is far from the path.
    """
    walls = _walls(data)
    path = _path(data)
    length = path_length(path.view(np.recarray))
    if not SHORTEST_PATH_M <= length <= LONGEST_PATH_M:
        raise InvalidInput(
            f"place {data.name}: path is {length:.4g} m long, allowed is {SHORTEST_PATH_M} to "
            f"{LONGEST_PATH_M:.0f} m; coordinates are read in meters"
        )
    _check_clearance(data.name, walls, path)
    run_out, room = data.run_out_m, data.along_room_m
    along = _along(path, run_out)
    routes = [
        (along, ALONG, (0.0, run_out), room),
        (along[::-1], AGAINST, (length, run_out), room),
    ]
    for i, route in enumerate(data.routes):
        points = np.array(route.points, dtype=np.float64)
        meeting = _meeting(f"place {data.name}: routes.{i}", path, points)
        routes.append((points, ACROSS, meeting, route.room_m))
    return Place(
        walls=walls,
        path=path,
        routes=pad_routes([points for points, *_ in routes]),
        route_kinds=np.array([kind for _, kind, *_ in routes], dtype=np.int64),
        route_anchors=np.array([anchor for *_, anchor, _ in routes], dtype=np.float64),
        route_rooms=np.array([room for *_, room in routes], dtype=np.float64),
    )


def _walls(data: PlaceData) -> Floats:
    walls = np.array(data.walls, dtype=np.float64).reshape(-1, 4)
    is_point = (walls[:, :2] == walls[:, 2:]).all(axis=1)
    if is_point.any():
        i = int(np.argmax(is_point))
        raise InvalidInput(
            f"place {data.name}: walls.{i}: given {walls[i].tolist()}, a wall has two ends"
        )
    return walls


def _path(data: PlaceData) -> Records:
    chosen = data.path
    if (chosen.points is None) == (chosen.circle is None):
        raise InvalidInput(f"place {data.name}: path takes either points or circle")
    if chosen.circle is not None:
        x, y = chosen.circle.center
        return circle_path(x, y - chosen.circle.radius_m, 0.0, chosen.circle.radius_m)
    return _polyline(f"place {data.name}: path.points", chosen.points, chosen.corner_radius_m)


def _polyline(field: str, points: list[Point] | Floats | None, radius_m: float) -> Records:
    try:
        return straight_path(np.array(points), radius_m)
    except ValueError as error:
        raise InvalidInput(f"{field}: {error}") from error


def _check_clearance(name: str, walls: Floats, path: Records) -> None:
    clearance_m, x, y = narrowest(walls, path)
    if clearance_m <= ROBOT_RADIUS_M:
        raise InvalidInput(
            f"place {name}: path passes a wall at {clearance_m:.2f} m near ({x:.1f}, {y:.1f}), "
            f"allowed is more than {ROBOT_RADIUS_M:.2f} m"
        )


def narrowest(
    walls: Floats, path: Records, before_end_m: float = -0.05
) -> tuple[float, float, float]:
    """Return the least distance from a path to a wall, inf without walls, and its position [m].

    Args:
        walls: (W, 4) x1, y1, x2, y2 [m].
        path: The robot's path.
        before_end_m: Length of the path's end to omit.
    """
    steps = np.arange(0.0, path_length(path.view(np.recarray)) - before_end_m, 0.05)
    points = sample_path(path, steps)[:, :2]
    nearest_m = np.full(len(points), np.inf)
    for wall in walls:
        nearest_m = np.minimum(nearest_m, _distances(points, wall))
    if not len(points):
        return np.inf, 0.0, 0.0
    i = int(np.argmin(nearest_m))
    return float(nearest_m[i]), float(points[i, 0]), float(points[i, 1])


def _distances(points: Floats, wall: Floats) -> Floats:
    """Return the distance of points (n, 2) to a wall, (n,) [m]."""
    start, along = wall[:2], wall[2:] - wall[:2]
    t = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
    return np.asarray(np.hypot(*(points - start - t[:, None] * along).T), dtype=np.float64)


def _along(path: Records, run_out_m: float) -> Floats:
    """Return the path as waypoints, straight pieces by their ends, with a run-out at each."""
    length = path_length(path.view(np.recarray))
    marks = [-run_out_m, 0.0]
    for piece in path:
        start, size = float(piece["s"]), float(piece["length"])
        parts = 1 if piece["curvature"] == 0.0 else max(int(np.ceil(size / ROUTE_STEP_M)), 1)
        marks += [start + size * (k + 1) / parts for k in range(parts)]
    return sample_path(path, np.array([*marks, length + run_out_m]))[:, :2]


def _meeting(field: str, path: Records, points: Floats) -> tuple[float, float]:
    """Return the arc lengths on path and route at their closest point."""
    on_path = np.arange(0.0, path_length(path.view(np.recarray)), 0.05)
    route = _polyline(f"{field}.points", points, 1e-6)
    length = path_length(route.view(np.recarray))
    if length > LONGEST_PATH_M:
        raise InvalidInput(
            f"{field} is {length:.4g} m long, allowed is up to {LONGEST_PATH_M:.0f} m; "
            "coordinates are read in meters"
        )
    on_route = np.arange(0.0, length, 0.05)
    route_points = sample_path(route, on_route)[:, :2]
    nearest_m, meeting = np.inf, (0.0, 0.0)
    for s, point in zip(on_path, sample_path(path, on_path)[:, :2], strict=True):
        distance = np.hypot(*(route_points - point).T)
        k = int(np.argmin(distance))
        if distance[k] < nearest_m:
            nearest_m, meeting = float(distance[k]), (float(s), float(on_route[k]))
    if nearest_m > 1.0:
        raise InvalidInput(f"{field} stays {nearest_m:.1f} m from the path, allowed is 1 m")
    return meeting


def pad_routes(points: list[Floats]) -> Floats:
    """Return waypoint lists of any sizes as one array (R, K, 3) of x, y and arc length [m]."""
    size = max(len(route) for route in points)
    routes = np.empty((len(points), size, 3))
    for row, route in zip(routes, points, strict=True):
        arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(route, axis=0).T)))
        row[: len(route)] = np.column_stack([route, arc])
        row[len(route) :] = row[len(route) - 1]
    return routes
