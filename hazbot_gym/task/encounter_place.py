"""Place of an encounter: the path that a recorded robot drove, without walls.

The recorded positions are simplified to a polyline (Douglas and Peucker 1973) with corners rounded
as widely as its legs allow. A policy then chooses the speed along it.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import Floats, Place
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.place_data import PathData, PlaceData, build_place
from hazbot_gym.task.tracks import RecordedRobot

SHORTEST_M = 1.0  # a robot that stands has no path
# Largest distance of a recorded position to the polyline and radius of its corners, in order of
# preference [m].
FITS = ((0.15, 1.0), (0.15, 0.5), (0.3, 0.5), (0.3, 0.25), (0.6, 0.25))


def encounter_place(name: str, robot: RecordedRobot) -> Place:
    """Return the place of an encounter.

    Raises:
        InvalidInput: The robot hardly moves, or turns too sharply.
    """
    for tolerance_m, radius_m in FITS:
        points = simplified(robot.positions, tolerance_m)
        length_m = float(np.hypot(*np.diff(points, axis=0).T).sum())
        if length_m < SHORTEST_M:
            raise InvalidInput(
                f"tracks: the robot of {name} drives {length_m:.2f} m, allowed are "
                f"{SHORTEST_M:g} m or more"
            )
        try:
            straight_path(points, radius_m)
        except ValueError:
            continue
        corners = [(float(x), float(y)) for x, y in points]
        path = PathData(points=corners, corner_radius_m=radius_m)
        return build_place(PlaceData(name=name, path=path))
    tolerance_m, radius_m = FITS[-1]
    raise InvalidInput(
        f"tracks: no path with corners of radius {radius_m:g} m is within {tolerance_m:g} m of the "
        f"robot of {name}"
    )


def simplified(points: Floats, tolerance_m: float) -> Floats:
    """Return the corners of a polyline within a tolerance of all points (n, 2)."""
    start, end = points[0], points[-1]
    off_m = _distances(points, start, end)
    farthest = int(off_m.argmax())
    if off_m[farthest] <= tolerance_m:
        return np.stack([start, end])
    before = simplified(points[: farthest + 1], tolerance_m)
    return np.concatenate([before[:-1], simplified(points[farthest:], tolerance_m)])


def _distances(points: Floats, start: Floats, end: Floats) -> Floats:
    """Return the distances of points to a segment [m]."""
    along = end - start
    squared = float(along @ along)
    share = np.clip((points - start) @ along / squared, 0.0, 1.0) if squared > 0.0 else 0.0
    nearest = start + np.multiply.outer(share, along)
    distances: Floats = np.hypot(*(points - nearest).T)
    return distances
