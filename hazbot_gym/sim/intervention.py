"""Intervention from outside: people are led by hand, added and removed between two decisions.

A person who is led walks straight to a point, at most at ``TOP_MPS``, and stops at walls. While
led, it is a scripted walker on a route of its own. Let go, it goes on by its model from the nearest
point of its former route; a scripted walker goes straight on in its former direction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.geometry import is_in_sight, nearest_on_segment, norm, route_pose
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import (
    AGAINST,
    GONE,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    ROBOT_RADIUS_M,
    SCRIPTED,
    SOCIAL_FORCE,
    Floats,
    PersonRecord,
    Records,
    records,
)
from hazbot_gym.sim.world import World

TOP_MPS = 2.5  # of a person who is led
ROOM_M = 0.1  # free distance of an added person to others and to the robot
TYPICAL_MPS = 1.34  # walking speed of an added person (Helbing and Molnar 1995)
ROUTE_M = 200.0  # length of the route of a person who is led


class _Led(NamedTuple):
    """A person who is led: its record before, and the row of its own route."""

    before: Records  # (1,)
    row: int


class Intervention:
    """Changes of the people of one episode of a world.

    Attributes:
        world: The world, which is changed.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._own_routes = len(world.place.routes)  # of the place
        self._led: dict[int, _Led] = {}

    def lead(self, person: int, x_m: float, y_m: float, dt_s: float) -> None:
        """Let a present person walk towards a point during the next decision.

        Args:
            person: Index of the person.
            x_m: The point.
            y_m: The same, other axis.
            dt_s: Decision period.
        """
        world = self.world
        if not self.is_present(person):
            return
        if person not in self._led:
            row = len(world.place.routes)
            self._led[person] = _Led(world.people[person : person + 1].copy(), row)
            _add_route(world)
        row, place = self._led[person].row, world.place
        walk_to(_fields(world.people)[person], place.routes, row, place.walls, x_m, y_m, dt_s)
        world.disturb()

    def release(self, person: int) -> None:
        """Let a person go on by its own model, if it is led."""
        if person not in self._led:
            return
        before, row = self._led.pop(person)
        if self.is_present(person):
            me = _fields(self.world.people)[person]
            go_on(me, _fields(before)[0], self.world.place.routes, row)
            self.world.disturb()

    @property
    def led(self) -> tuple[int, ...]:
        """The people who are led."""
        return tuple(self._led)

    def remove(self, person: int) -> None:
        """Remove a person for good."""
        if self.is_present(person):
            self._led.pop(person, None)
            self.world.people["status"][person] = GONE
            self.world.disturb()

    def newcomer(self, x_m: float, y_m: float) -> Records | None:
        """Return the record (1,) of a person who starts at a point and walks the nearest route.

        Of two routes at the same distance it takes the one against the robot's way. None if there
        is no room at the point, or a wall between it and each route.
        """
        world, place = self.world, self.world.place
        people = world.people[world.people["status"] == PRESENT]
        distances = np.hypot(people["x"] - x_m, people["y"] - y_m) - people["radius"]
        robot = world.robots[0]
        to_robot = norm(robot["x"] - x_m, robot["y"] - y_m) - ROBOT_RADIUS_M
        if min(to_robot, *distances, math.inf) < PERSON_RADIUS_M + ROOM_M:
            return None
        choices = []
        for route in range(self._own_routes):
            s, x, y, away_m = nearest_on_route(place.routes, route, x_m, y_m)
            if is_in_sight(x, y, x_m, y_m, place.walls):
                is_against = place.route_kinds[route] == AGAINST
                choices.append((round(away_m, 6), not is_against, route, s))
        if not choices:
            return None
        *_, route, s = min(choices)
        return _walker(place.routes, route, s, x_m, y_m, float(place.route_rooms[route]))

    def is_present(self, person: int) -> bool:
        """Return True if there is such a person, who has entered and not left."""
        people = self.world.people
        return person < len(people) and bool(people["status"][person] == PRESENT)


def _walker(routes: Floats, route: int, s: float, x_m: float, y_m: float, room_m: float) -> Records:
    """Return a walker (1,) at a point, on a lane of a route as near to it as there is room."""
    x, y, tx, ty = route_pose(routes, route, s)
    offset = (y_m - y) * tx - (x_m - x) * ty
    person = records(PERSON, 1)
    person["x"], person["y"], person["s"], person["route"] = x_m, y_m, s, route
    person["vx"], person["vy"] = TYPICAL_MPS * tx, TYPICAL_MPS * ty
    person["offset"] = person["sidestep_offset"] = float(np.clip(offset, -room_m, room_m))
    person["radius"], person["desired_speed"] = PERSON_RADIUS_M, TYPICAL_MPS
    person["model"], person["status"] = SOCIAL_FORCE, PRESENT
    return person


def _add_route(world: World) -> None:
    """Add a route to the world's place, at the end of the others."""
    place = world.place
    world.place = place._replace(
        routes=np.concatenate([place.routes, np.zeros((1, *place.routes.shape[1:]))]),
        route_kinds=np.append(place.route_kinds, AGAINST),
        route_anchors=np.concatenate([place.route_anchors, np.zeros((1, 2))]),
        route_rooms=np.append(place.route_rooms, 0.0),
    )


def _fields(people: Records) -> Records:
    """Return records whose fields are attributes, as in kernels."""
    return people.view(np.recarray)


# --- one person, also in compiled code -----------------------------------------------------------


@scalar
def walk_to(
    me: PersonRecord, routes: Floats, row: int, walls: Floats, x_m: float, y_m: float, dt_s: float
) -> None:
    """Let a person walk towards a point for a decision, at most at ``TOP_MPS``, up to a wall.

    Args:
        me: PERSON record, changed.
        routes: (R, K, 3) routes, of which one is changed.
        row: The person's own route.
        walls: (W, 4) [m].
        x_m: The point.
        y_m: The same, other axis.
        dt_s: Decision period.
    """
    away_m = norm(x_m - me.x, y_m - me.y)
    ux, uy = 1.0, 0.0
    if away_m > 0.0:
        ux, uy = (x_m - me.x) / away_m, (y_m - me.y) / away_m
    speed_mps = min(away_m / dt_s, TOP_MPS)
    reach_m = speed_mps * dt_s + PERSON_RADIUS_M
    if not is_in_sight(me.x, me.y, me.x + reach_m * ux, me.y + reach_m * uy, walls):
        speed_mps = 0.0
    _walk_straight(me, routes, row, ux, uy, speed_mps)


@scalar
def go_on(me: PersonRecord, before: PersonRecord, routes: Floats, row: int) -> None:
    """Let a person who was led go on; arguments as of ``walk_to``, and its record before."""
    if before.model == SCRIPTED:
        speed_mps = norm(before.vx, before.vy)
        ux, uy = 1.0, 0.0
        if speed_mps > 0.0:
            ux, uy = before.vx / speed_mps, before.vy / speed_mps
        _walk_straight(me, routes, row, ux, uy, speed_mps)
        return
    me.model, me.route, me.desired_speed = before.model, before.route, before.desired_speed
    me.offset, me.sidestep_s = before.offset, before.sidestep_s
    me.sidestep_offset = before.sidestep_offset
    me.s = nearest_on_route(routes, before.route, me.x, me.y)[0]


@scalar
def _walk_straight(
    me: PersonRecord, routes: Floats, row: int, ux: float, uy: float, speed_mps: float
) -> None:
    """Let a person walk straight on from where it is, along a route of its own."""
    route = routes[row]
    for k in range(route.shape[0]):
        length_m = ROUTE_M if k > 0 else 0.0
        route[k, 0], route[k, 1] = me.x + length_m * ux, me.y + length_m * uy
        route[k, 2] = length_m
    me.model, me.route, me.s = SCRIPTED, row, 0.0
    me.offset, me.sidestep_offset, me.sidestep_s = 0.0, 0.0, 0.0
    me.desired_speed, me.blocked = speed_mps, 0.0
    me.vx, me.vy = speed_mps * ux, speed_mps * uy


@scalar
def nearest_on_route(
    routes: Floats, route: int, x_m: float, y_m: float
) -> tuple[float, float, float, float]:
    """Return the point of a route nearest to another point: s, x, y and the distance [m]."""
    points = routes[route]
    s, nearest_x, nearest_y, nearest_m = 0.0, 0.0, 0.0, math.inf
    for k in range(points.shape[0] - 1):
        x1, y1, s1 = points[k, 0], points[k, 1], points[k, 2]
        if points[k + 1, 2] <= s1 and nearest_m < math.inf:  # padding
            break
        x, y = nearest_on_segment(x_m, y_m, x1, y1, points[k + 1, 0], points[k + 1, 1])
        away_m = norm(x - x_m, y - y_m)
        if away_m < nearest_m:
            s, nearest_x, nearest_y, nearest_m = s1 + norm(x - x1, y - y1), x, y, away_m
    return s, nearest_x, nearest_y, nearest_m
