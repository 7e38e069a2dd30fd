"""Walls from a walkable area in well-known text (WKT)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.track_formats.table import MOST_WALLS


def walls_of(name: str, areas: Sequence[object]) -> Floats:
    """Return the edges (W, 4) of the union of areas, x1, y1, x2, y2 [m].

    Args:
        name: of the file.
        areas: Polygons, multipolygons or collections of them, as WKT.

    Raises:
        InvalidInput: a text is no WKT of an area.
        MissingExtra: shapely is not installed.
    """
    try:
        import shapely
    except ImportError as error:
        raise MissingExtra("shapely", "tracks") from error
    if not areas:
        return np.zeros((0, 4))
    try:
        with np.errstate(invalid="ignore"):  # NaN is rejected below
            edges = shapely.boundary(shapely.union_all(shapely.from_wkt(list(areas))))
        lines = [shapely.get_coordinates(line) for line in shapely.get_parts(edges)]
    except (shapely.errors.ShapelyError, TypeError, ValueError) as error:
        raise InvalidInput(f"{name}: geometry: {' '.join(str(error).split()):.100}") from None
    walls = [np.hstack([line[:-1], line[1:]]) for line in lines]
    found = np.concatenate([np.zeros((0, 4)), *walls])
    if len(found) > MOST_WALLS:
        raise InvalidInput(f"{name}: geometry: {len(found)} walls, allowed are {MOST_WALLS}")
    if not np.isfinite(found).all():
        raise InvalidInput(f"{name}: geometry: a coordinate is not a finite number")
    return found
