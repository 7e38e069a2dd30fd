"""Robot path and walls for a recording: a straight line through the recorded area.

In a corridor the line runs along its middle from end to end. In the open it runs through the median
of all sightings along their principal axis, and spans 90 % of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.geometry import segments_cross
from hazbot_gym.core.state import ROBOT_RADIUS_M, Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.tracks import Corridor, Recording

SPAN_PERCENT = (5.0, 95.0)


class ReplayFrame(NamedTuple):
    """A robot's path through a recording.

    Attributes:
        start: (2,) start of the robot [m].
        end: (2,) goal of the robot [m].
        walls: (W, 4) segments x1, y1, x2, y2 [m].
    """

    start: Floats
    end: Floats
    walls: Floats


def replay_frame(
    recording: Recording,
    *,
    is_reversed: bool = False,
    lateral_m: float = 0.0,
    robot_radius_m: float = ROBOT_RADIUS_M,
) -> ReplayFrame:
    """Return the robot's path through a recording.

    Args:
        recording: The recording.
        is_reversed: Whether to drive from the far end to the near one.
        lateral_m: Offset to the left of the middle, in driving direction [m].
        robot_radius_m: Radius that must fit between the walls [m].

    Raises:
        InvalidInput: the robot does not fit between the walls there.
    """
    corridor = recording.corridor
    ends = _middle_line(corridor) if corridor else _main_line(recording.positions)
    start, end = ends[::-1] if is_reversed else ends
    along = (end - start) / np.hypot(*(end - start))
    left = np.array([-along[1], along[0]])
    start, end = start + lateral_m * left, end + lateral_m * left
    for side in (-robot_radius_m, robot_radius_m):
        a, b = start + side * left, end + side * left
        if any(segments_cross(*a, *b, *wall) for wall in recording.walls) or (
            corridor and not _is_inside(corridor, (a + b) / 2.0)
        ):
            where = f"{lateral_m} m to the left of" if lateral_m else "along"
            raise InvalidInput(
                f"tracks: {recording.name}: a robot of radius {robot_radius_m} m does not fit "
                f"between the walls {where} the middle, from {_point(start)} to {_point(end)}"
            )
    return ReplayFrame(start, end, recording.walls)


def _point(point: Floats) -> str:
    return f"({point[0]:.1f}, {point[1]:.1f})"


def _middle_line(corridor: Corridor) -> Floats:
    (x1, x2), (y1, y2) = corridor.x_m, corridor.y_m
    if corridor.axis == "x":
        return np.array([[x1, (y1 + y2) / 2.0], [x2, (y1 + y2) / 2.0]])
    return np.array([[(x1 + x2) / 2.0, y1], [(x1 + x2) / 2.0, y2]])


def _main_line(positions: Floats) -> Floats:
    """Return the ends (2, 2) of the line through the median along the first principal component."""
    middle = np.median(positions, axis=0)
    axis = np.linalg.eigh(np.cov(positions.T))[1][:, -1]
    axis *= np.sign(axis[np.argmax(np.abs(axis))])  # its sign is arbitrary: towards +x or +y
    spread = np.percentile((positions - middle) @ axis, SPAN_PERCENT)
    return np.asarray(middle + spread[:, None] * axis, dtype=np.float64)


def _is_inside(corridor: Corridor, point: Floats) -> bool:
    (x1, x2), (y1, y2) = corridor.x_m, corridor.y_m
    return bool(x1 <= point[0] <= x2 and y1 <= point[1] <= y2)
