"""Plane geometry: angles, distances to segments, lines of sight, and paths of lines and arcs.

A path is a sequence of pieces of constant curvature (``PATH_PIECE``), so that the reference pose
and curvature at any arc length have a closed form.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import PATH_PIECE, Floats, Records, records

STRAIGHT_PER_M = 1e-9  # curvature below which a piece is treated as a line [1/m]


@scalar
def wrap_angle(angle: float) -> float:
    """Return the angle in (-pi, pi]."""
    turns = np.ceil((angle - math.pi) / (2.0 * math.pi))
    return min(float(angle - turns * (2.0 * math.pi)), math.pi)


@scalar
def clip(value: float, low: float, high: float) -> float:
    """Return the value clipped to two bounds."""
    return min(max(value, low), high)


@scalar
def norm(x: float, y: float) -> float:
    """Return the length of a vector; faster than hypot, without its protection against overflow."""
    return math.sqrt(x * x + y * y)


@scalar
def nearest_on_segment(
    px: float, py: float, x1: float, y1: float, x2: float, y2: float
) -> tuple[float, float]:
    """Return the point of a segment that is nearest to (px, py)."""
    dx, dy = x2 - x1, y2 - y1
    squared = dx * dx + dy * dy
    t = 0.0
    if squared > 0.0:
        t = clip(((px - x1) * dx + (py - y1) * dy) / squared, 0.0, 1.0)
    return x1 + t * dx, y1 + t * dy


@scalar
def may_be_near(
    px: float, py: float, x1: float, y1: float, x2: float, y2: float, reach: float
) -> bool:
    """Return True if a segment's bounding box is within reach of (px, py)."""
    is_near_x = min(x1, x2) - reach <= px and px <= max(x1, x2) + reach
    return is_near_x and min(y1, y2) - reach <= py and py <= max(y1, y2) + reach


@scalar
def segments_cross(
    ax: float, ay: float, bx: float, by: float, x1: float, y1: float, x2: float, y2: float
) -> bool:
    """Return True if the open segment a-b crosses the segment 1-2 (touching parallels do not)."""
    rx, ry = bx - ax, by - ay
    sx, sy = x2 - x1, y2 - y1
    cross = rx * sy - ry * sx
    if cross == 0.0:
        return False
    t = ((x1 - ax) * sy - (y1 - ay) * sx) / cross
    u = ((x1 - ax) * ry - (y1 - ay) * rx) / cross
    return 0.0 < t < 1.0 and 0.0 <= u <= 1.0


@scalar
def is_in_sight(ax: float, ay: float, bx: float, by: float, walls: Floats) -> bool:
    """Return True if no wall is between two points; walls: (W, 4) [m]."""
    for i in range(walls.shape[0]):
        if segments_cross(ax, ay, bx, by, walls[i, 0], walls[i, 1], walls[i, 2], walls[i, 3]):
            return False
    return True


# --- paths ---------------------------------------------------------------------------------------


@scalar
def path_length(path: Records) -> float:
    """Return the arc length of a path [m]."""
    last = path[path.shape[0] - 1]
    return float(last.s + last.length)


@scalar
def piece_at(path: Records, s: float) -> int:
    """Return the index of the piece of a path at arc length s."""
    i = 0
    while i + 1 < path.shape[0] and s >= path[i + 1].s:
        i += 1
    return i


@scalar
def path_pose(path: Records, s: float) -> tuple[float, float, float, float]:
    """Return x, y, heading and curvature at arc length s; beyond an end the path goes on straight.

    On a piece with start (x0, y0, psi) and curvature k, with l = s - s0 (exact arc):

        x = x0 + (sin(psi + k l) - sin psi)/k
        y = y0 - (cos(psi + k l) - cos psi)/k
        heading = psi + k l
    """
    piece = path[piece_at(path, s)]
    along = s - piece.s
    on_piece = clip(along, 0.0, piece.length)
    beyond = along - on_piece
    curvature = piece.curvature
    heading = piece.heading + curvature * on_piece
    if abs(curvature) < STRAIGHT_PER_M:
        cosine, sine = piece.cos, piece.sin
        x, y = piece.x + on_piece * cosine, piece.y + on_piece * sine
    else:
        sine, cosine = sin_cos(heading)
        x = piece.x + (sine - piece.sin) / curvature
        y = piece.y - (cosine - piece.cos) / curvature
    if beyond != 0.0:
        x += beyond * cosine
        y += beyond * sine
        curvature = 0.0
    return x, y, heading, curvature


@scalar
def route_pose(routes: Floats, route: int, s: float) -> tuple[float, float, float, float]:
    """Return the point of a route at arc length s and its unit tangent there; straight on at ends.

    Args:
        routes: (R, K, 3) waypoints x, y and arc length, rows padded with their last waypoint [m].
        route: Row of the route.
        s: Arc length [m].
    """
    points = routes[route]
    k = 0
    while k + 2 < points.shape[0] and s > points[k + 1, 2] and points[k + 2, 2] > points[k + 1, 2]:
        k += 1
    per_m = 1.0 / (points[k + 1, 2] - points[k, 2])
    tx = per_m * (points[k + 1, 0] - points[k, 0])
    ty = per_m * (points[k + 1, 1] - points[k, 1])
    along = s - points[k, 2]
    return points[k, 0] + along * tx, points[k, 1] + along * ty, tx, ty


def straight_path(points: Floats, corner_radius_m: float = 1.0) -> Records:
    """Return a path along a polyline (n, 2) whose corners are rounded to a radius [m].

    Raises:
        ValueError: fewer than two points, coincident points, or a corner whose legs are too short;
            points and corners are counted from 1.
    """
    points = np.asarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[0] < 2 or points.shape[1] != 2:
        raise ValueError(f"a path needs at least two points (x, y), given shape {points.shape}")
    legs = np.diff(points, axis=0)
    lengths = np.hypot(legs[:, 0], legs[:, 1])
    if not np.all(lengths > 0.0):
        i = int(np.argmin(lengths))
        raise ValueError(f"point {i + 1} and point {i + 2} coincide at {points[i].tolist()}")
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    turns = np.array([wrap_angle(b - a) for a, b in itertools.pairwise(headings)])
    cut = corner_radius_m * np.tan(np.abs(turns) / 2.0)  # length of each leg used by a rounding
    left_over = lengths - np.append(cut, 0.0) - np.append(0.0, cut)
    if not np.all(left_over >= -1e-12):
        raise ValueError(_too_sharp(points, corner_radius_m, cut, int(np.argmin(left_over))))
    pieces: list[tuple[float, float]] = []  # length, curvature
    for i, straight in enumerate(left_over):
        pieces.append((float(straight), 0.0))
        if i < len(turns) and turns[i] != 0.0:
            curvature = math.copysign(1.0 / corner_radius_m, turns[i])
            pieces.append((abs(float(turns[i])) * corner_radius_m, curvature))
    return chain_path(float(points[0, 0]), float(points[0, 1]), float(headings[0]), pieces)


def _too_sharp(points: Floats, radius_m: float, cut: Floats, leg: int) -> str:
    """Return the message about a corner whose rounding exceeds its leg."""
    k = max((k for k in (leg - 1, leg) if 0 <= k < len(cut)), key=lambda k: cut[k])
    corner = f"corner {k + 1} at {points[k + 1].tolist()}"
    if cut[k] > 1000.0 * radius_m:
        return f"{corner} turns back on itself"
    length = float(np.hypot(*(points[leg + 1] - points[leg])))
    needed = float(cut[max(leg - 1, 0) : leg + 1].sum())
    return (
        f"{corner}: corner_radius_m = {radius_m} is too large: the leg from point {leg + 1} to "
        f"point {leg + 2} is {length:.3g} m long, and its rounded corners take {needed:.3g} m"
    )


def circle_path(x: float, y: float, heading: float, radius_m: float) -> Records:
    """Return one lap, counter-clockwise, of a circle that starts at (x, y) with a heading."""
    return chain_path(x, y, heading, [(2.0 * math.pi * radius_m, 1.0 / radius_m)])


def chain_path(x: float, y: float, heading: float, pieces: list[tuple[float, float]]) -> Records:
    """Return the path that starts at (x, y) with a heading, of pieces of a length and curvature."""
    pieces = [piece for piece in pieces if piece[0] > 0.0]
    path = records(PATH_PIECE, len(pieces))
    s = 0.0
    for i, (length, curvature) in enumerate(pieces):
        sine, cosine = sin_cos(heading)
        path[i] = (s, length, x, y, heading, curvature, cosine, sine)
        x, y, heading, _ = path_pose(path[i : i + 1].view(np.recarray), s + length)
        s += length
    return path


def sample_path(path: Records, s: Floats) -> Floats:
    """Return x, y, heading, curvature at each arc length: shape (n, 4)."""
    view = path.view(np.recarray)
    return np.array([path_pose(view, float(value)) for value in s]).reshape(-1, 4)
