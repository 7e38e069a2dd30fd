"""Contact test of the robot with people and walls, without a physics engine.

A disc touches a disc or segment if their distance is below the sum of the radii, strictly, as in
Chipmunk's narrow phase. A positive slack excludes contacts within a social period, so that both
engines can skip the test.
"""

from __future__ import annotations

from hazbot_gym.core.geometry import may_be_near, nearest_on_segment, norm
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import (
    NO_CONTACT,
    PRESENT,
    ROBOT_RADIUS_M,
    TOP_SPEED_MPS,
    WALL,
    Floats,
    Records,
    RobotRecord,
)

ENOUGH_M = 1.0  # cap of the slack


@scalar
def wall_distance(robot: RobotRecord, walls: Floats, within_m: float) -> float:
    """Return the distance from the robot's centre to the nearest wall, at most ``within_m`` [m]."""
    nearest = within_m
    for k in range(walls.shape[0]):
        x1, y1, x2, y2 = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        if may_be_near(robot.x, robot.y, x1, y1, x2, y2, nearest):
            x, y = nearest_on_segment(robot.x, robot.y, x1, y1, x2, y2)
            nearest = min(nearest, norm(x - robot.x, y - robot.y))
    return nearest


@scalar
def slack(people: Records, walls: Floats, robot: RobotRecord, dt_s: float) -> float:
    """Return a lower bound of the clearance to any contact within dt [m].

    It is capped at 1 m.
    """
    reach_m = ROBOT_RADIUS_M + TOP_SPEED_MPS * dt_s
    left_m = wall_distance(robot, walls, reach_m + ENOUGH_M) - reach_m
    for i in range(people.shape[0]):
        me = people[i]
        dx, dy = abs(me.x - robot.x), abs(me.y - robot.y)
        stride_m = (abs(me.vx) + abs(me.vy)) * dt_s  # bound of its travel within dt
        if me.status == PRESENT and max(dx, dy) < reach_m + me.radius + stride_m + ENOUGH_M:
            gap_m = norm(dx, dy) - me.radius - norm(me.vx, me.vy) * dt_s
            left_m = min(left_m, gap_m - reach_m)
    return left_m


@scalar
def find_contact(people: Records, walls: Floats, robot: RobotRecord, elapsed_s: float) -> int:
    """Return the index of the first touched person, ``WALL`` or ``NO_CONTACT``.

    Args:
        people: (P,) PERSON records at the last social step.
        walls: (W, 4) segments [m].
        robot: The robot's record.
        elapsed_s: Time since that social step, at constant velocities [s].
    """
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            dx = me.x + me.vx * elapsed_s - robot.x
            dy = me.y + me.vy * elapsed_s - robot.y
            reach = me.radius + ROBOT_RADIUS_M
            if dx * dx + dy * dy < reach * reach:
                return i
    wall_m = wall_distance(robot, walls, 2.0 * ROBOT_RADIUS_M)
    return WALL if wall_m < ROBOT_RADIUS_M else NO_CONTACT
