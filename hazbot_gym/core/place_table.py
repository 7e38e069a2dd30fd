"""Table of places: padded arrays, from which a kernel selects one place per world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import PATH_PIECE, Floats, Place, Records


class PlaceTable(NamedTuple):
    """L places, padded to the size of the largest."""

    walls: Floats  # (L, W, 4)
    wall_counts: npt.NDArray[np.int64]  # (L,)
    paths: Records  # (L, M)
    path_counts: npt.NDArray[np.int64]  # (L,)
    routes: Floats  # (L, R, K, 3)
    route_counts: npt.NDArray[np.int64]  # (L,)
    route_kinds: npt.NDArray[np.int64]  # (L, R)
    route_anchors: Floats  # (L, R, 2)
    route_rooms: Floats  # (L, R)
    entry_counts: npt.NDArray[np.int64]  # (L,) R, or 0
    entry_times_s: Floats  # (L, R or 0)
    entry_speeds_mps: Floats  # (L, R or 0)


@scalar
def place_at(table: PlaceTable, i: int) -> Place:
    """Return place i as views into the table."""
    routes, entries = table.route_counts[i], table.entry_counts[i]
    return Place(
        table.walls[i, : table.wall_counts[i]],
        table.paths[i, : table.path_counts[i]],
        table.routes[i, :routes],
        table.route_kinds[i, :routes],
        table.route_anchors[i, :routes],
        table.route_rooms[i, :routes],
        table.entry_times_s[i, :entries],
        table.entry_speeds_mps[i, :entries],
    )


def stack_places(places: list[Place]) -> PlaceTable:
    """Return places as one table."""
    size = len(places)
    table = PlaceTable(
        walls=np.zeros((size, max(len(p.walls) for p in places), 4)),
        wall_counts=np.array([len(p.walls) for p in places]),
        paths=np.zeros((size, max(len(p.path) for p in places)), PATH_PIECE),
        path_counts=np.array([len(p.path) for p in places]),
        routes=np.zeros((size, *np.max([p.routes.shape for p in places], axis=0))),
        route_counts=np.array([len(p.routes) for p in places]),
        route_kinds=np.zeros((size, max(len(p.routes) for p in places)), np.int64),
        route_anchors=np.zeros((size, max(len(p.routes) for p in places), 2)),
        route_rooms=np.zeros((size, max(len(p.routes) for p in places))),
        entry_counts=np.array([len(p.entry_times_s) for p in places]),
        entry_times_s=np.zeros((size, max(len(p.entry_times_s) for p in places))),
        entry_speeds_mps=np.zeros((size, max(len(p.entry_times_s) for p in places))),
    )
    for i, place in enumerate(places):
        routes, waypoints = place.routes.shape[:2]
        table.walls[i, : len(place.walls)] = place.walls
        table.paths[i, : len(place.path)] = place.path
        table.routes[i, :routes, :waypoints] = place.routes
        table.routes[i, :routes, waypoints:] = place.routes[:, -1:]
        table.route_kinds[i, :routes] = place.route_kinds
        table.route_anchors[i, :routes] = place.route_anchors
        table.route_rooms[i, :routes] = place.route_rooms
        table.entry_times_s[i, : len(place.entry_times_s)] = place.entry_times_s
        table.entry_speeds_mps[i, : len(place.entry_times_s)] = place.entry_speeds_mps
    return table
