"""When the robot touches somebody or something: the test that needs no physics engine.

Discs touch discs and segments where their distance falls below the sum of the radii, strictly, as
in Chipmunk's own narrow phase. The slack tells when nothing can touch within a social period at
all, which spares both engines the looking.
"""

from __future__ import annotations

import math

from hazbot_gym.core.geometry import nearest_on_segment, norm
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import (
    NO_CONTACT,
    PRESENT,
    ROBOT_RADIUS_M,
    WALL,
    Floats,
    Record,
    Records,
)

TOP_SPEED_MPS = 2.0  # the robot is never this fast


@scalar
def wall_distance(robot: Record, walls: Floats) -> float:
    """Return the distance from the robot's centre to the nearest wall, inf without walls [m]."""
    nearest = math.inf
    for k in range(walls.shape[0]):
        x, y = nearest_on_segment(
            robot.x, robot.y, walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        )
        nearest = min(nearest, norm(x - robot.x, y - robot.y))
    return nearest


@scalar
def slack(people: Records, walls: Floats, robot: Record, dt_s: float) -> float:
    """Return how far everything stays from touching the robot within dt, at least [m]."""
    nearest = wall_distance(robot, walls) - ROBOT_RADIUS_M
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            gap = norm(me.x - robot.x, me.y - robot.y) - me.radius - ROBOT_RADIUS_M
            nearest = min(nearest, gap - norm(me.vx, me.vy) * dt_s)
    return nearest - TOP_SPEED_MPS * dt_s


@scalar
def find_contact(people: Records, walls: Floats, robot: Record, elapsed_s: float) -> int:
    """Return whom the robot touches, ``WALL`` or ``NO_CONTACT``; of several people the first.

    Args:
        people: (P,) PERSON records as they stood at the last social step.
        walls: (W, 4) segments [m].
        robot: The robot's record.
        elapsed_s: Time since that social step, for which people kept their velocity [s].
    """
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            dx = me.x + me.vx * elapsed_s - robot.x
            dy = me.y + me.vy * elapsed_s - robot.y
            reach = me.radius + ROBOT_RADIUS_M
            if dx * dx + dy * dy < reach * reach:
                return i
    return WALL if wall_distance(robot, walls) < ROBOT_RADIUS_M else NO_CONTACT
