"""Paths of several robots in a place: opposite to each other, and across, each in its own lane.

The place's path is taken both ways, and so are the routes across it, cut such that robots at equal
speed meet where path and route meet. More robots than ways follow the first ones. All keep right.
"""

from __future__ import annotations

import itertools
import math
from numbers import Real
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.geometry import chain_path, path_length, path_pose, straight_path
from hazbot_gym.core.noise import ROBOT_STARTS, uniform4
from hazbot_gym.core.state import ACROSS, ROBOT_RADIUS_M, Floats, Place, Records
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.place_data import narrowest

# Usual lateral offsets, the first where there is room. At 0.45 m many people choose the side of the
# wall, where there is no room in ways of 2 m, and stand before a robot that stands.
USUAL_RIGHT_M = (0.6, 0.45)
START_SPREAD_M = 2.0
FOLLOWING_M = 1.0  # least distance of the starts of two robots on the same way


class Lanes(NamedTuple):
    """Lateral offset of the paths, and spread of their starts."""

    right_m: float  # distance of a robot's path from the way, to the right
    spread_m: float  # starts lie up to this far behind the beginning of the way


class _Way(NamedTuple):
    """A stretch of a path, in one direction."""

    path: Records
    first_m: float
    last_m: float
    is_backward: bool = False


def robot_paths(place: Place, robots: int, lanes: Lanes, key: int) -> list[Records]:
    """Return the path of each robot in the scenario of a key."""
    shares = [uniform4(np.uint64(key), ROBOT_STARTS, 0, i)[0] for i in range(robots)]
    return _paths(place, lanes, shares)


def lanes_in(
    name: str, place: Place, robots: int, *, right_m: float | None, spread_m: float
) -> Lanes:
    """Return the lanes of a place, by default the usual ones.

    Raises:
        InvalidInput: A length cannot be used, the place is too narrow in some scenario, or a bend
            too sharp for the lane; one line.
    """
    if not (right_m is None or _is_finite(right_m)):
        raise InvalidInput(f"keep_right_m: given {right_m!r}, allowed are finite numbers")
    if not (_is_finite(spread_m) and spread_m >= 0.0):
        allowed = "finite numbers of at least 0"
        raise InvalidInput(f"start_spread_m: given {spread_m!r}, allowed are {allowed}")
    for offset_m in USUAL_RIGHT_M if right_m is None else (right_m,):
        lanes = Lanes(offset_m, spread_m)
        paths = _paths(place, lanes, [1.0] * robots)
        clearance_m, x, y = min(narrowest(place.walls, path) for path in paths)
        if clearance_m > ROBOT_RADIUS_M:
            return lanes
    raise InvalidInput(
        f"place {name}: with keep_right_m = {offset_m:g} the path of a robot passes a wall at "
        f"{clearance_m:.2f} m near ({x:.1f}, {y:.1f}), allowed is more than {ROBOT_RADIUS_M:.2f} m"
    )


def _is_finite(given: object) -> bool:
    return isinstance(given, Real) and math.isfinite(given)


def _paths(place: Place, lanes: Lanes, shares: list[float]) -> list[Records]:
    ways = _ways(place)
    paths = []
    for i, share in enumerate(shares):
        row = i // len(ways)
        behind_m = share * lanes.spread_m + row * (lanes.spread_m + FOLLOWING_M)
        paths.append(_lane(ways[i % len(ways)], lanes.right_m, behind_m))
    return paths


def _ways(place: Place) -> list[_Way]:
    length_m = path_length(place.path.view(np.recarray))
    ways = [_Way(place.path, 0.0, length_m), _Way(place.path, 0.0, length_m, True)]
    for route in np.flatnonzero(place.route_kinds == ACROSS):
        on_path, on_route = place.route_anchors[route]
        first_m = float(on_route - on_path)
        ways.append(_Way(_route_path(place.routes[route]), first_m, first_m + length_m))
    return ways


def _route_path(waypoints: Floats) -> Records:
    """Return a route as a path; ``waypoints`` (K, 3) repeat the last."""
    is_new = np.append(True, np.diff(waypoints[:, 2]) > 0.0)
    try:
        return straight_path(waypoints[is_new, :2])
    except ValueError as error:
        raise InvalidInput(f"robots: a route of the place is no path for one: {error}") from error


def _lane(way: _Way, right_m: float, behind_m: float) -> Records:
    """Return the path to the right of a way, starting some distance behind its beginning."""
    first, last = way.first_m, way.last_m
    if way.is_backward:
        last += behind_m
    else:
        first -= behind_m
    view = way.path.view(np.recarray)
    ends = [float(s) for s in (*way.path["s"], path_length(view)) if first < s < last]
    pieces = [
        (b - a, path_pose(view, 0.5 * (a + b))[3])
        for a, b in itertools.pairwise([first, *ends, last])
    ]
    x, y, heading, _ = path_pose(view, last if way.is_backward else first)
    if way.is_backward:
        heading += math.pi
        pieces = [(length, -curvature) for length, curvature in reversed(pieces)]
    widths = [1.0 + curvature * right_m for _, curvature in pieces]
    if min(widths) <= 0.0:
        raise InvalidInput(
            f"keep_right_m: given {right_m:g}, allowed is less than each bend's radius"
        )
    return chain_path(
        x + right_m * math.sin(heading),
        y - right_m * math.cos(heading),
        heading,
        [
            (length * w, curvature / w)
            for (length, curvature), w in zip(pieces, widths, strict=True)
        ],
    )
