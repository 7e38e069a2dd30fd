from __future__ import annotations

import numpy as np

from hazbot_gym.core.geometry import route_pose
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.place_table import PlaceTable, place_at, stack_places
from hazbot_gym.core.state import Floats, Place
from hazbot_gym.task.places import PLACES, load_place


@kernel
def last_wall(table: PlaceTable, i: int, out: Floats) -> None:
    walls = place_at(table, i).walls
    out[:] = walls[walls.shape[0] - 1]


def test_places_come_back_from_the_table_as_they_went_in() -> None:
    places = [load_place(name) for name in PLACES]
    table = stack_places(places)

    for i, place in enumerate(places):
        again = place_at(table, i)
        for name in set(Place._fields) - {"routes"}:
            assert np.array_equal(getattr(again, name), getattr(place, name)), name
        waypoints = place.routes.shape[1]
        assert np.array_equal(again.routes[:, :waypoints], place.routes)


def test_longer_rows_of_waypoints_do_not_change_the_routes() -> None:
    corridor, circle = load_place("corridor"), load_place("circle")
    again = place_at(stack_places([circle, corridor]), 1)

    assert again.routes.shape[1] > corridor.routes.shape[1]
    assert np.array_equal(again.routes[:, -1], corridor.routes[:, -1]), "where people leave"
    for route in range(len(corridor.routes)):
        for s in (-1.0, 3.0, 40.0):
            assert route_pose(again.routes, route, s) == route_pose(corridor.routes, route, s)


def test_kernels_read_the_table_too() -> None:
    out = np.empty(4)
    last_wall(stack_places([load_place("open"), load_place("doorway")]), 1, out)

    assert out.tolist() == load_place("doorway").walls[-1].tolist()
