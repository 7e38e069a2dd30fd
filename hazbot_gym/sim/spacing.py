"""Collision avoidance of walkers: velocity limits towards near bodies and walls.

Social forces are soft. Therefore components of a person's new velocity that would lead into a body
or a wall within the social step are removed. Two people share the gap between them, so that they
never overlap. A robot can still drive into people.
"""

from __future__ import annotations

from hazbot_gym.core.geometry import may_be_near, nearest_on_segment, norm
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import PRESENT, ROBOT_RADIUS_M, PersonRecord, Place, Records, RobotRecord

REACH_M = 1.0  # obstacles beyond this distance are out of reach within a social step
ROBOT_MARGIN_M = 0.05  # clearance that people keep from the robot if possible


@scalar
def hold_back(
    vx: float, vy: float, dx: float, dy: float, limit_mps: float, may_slide: bool
) -> tuple[float, float]:
    """Limit the component of a velocity in the direction (dx, dy).

    Args:
        vx: Velocity [m/s].
        vy: The same, other axis.
        dx: Direction of the obstacle, of any length.
        dy: The same, other axis.
        limit_mps: Largest speed in that direction; negative counts as zero.
        may_slide: Whether to keep the perpendicular component, or to scale the whole velocity.
    """
    distance = max(norm(dx, dy), 1e-6)
    nx, ny = dx / distance, dy / distance
    along, limit = vx * nx + vy * ny, max(limit_mps, 0.0)
    if along <= limit:
        return vx, vy
    if may_slide:
        return vx - (along - limit) * nx, vy - (along - limit) * ny
    return vx * limit / along, vy * limit / along


@scalar
def keep_off_robot(
    me: PersonRecord, robot: RobotRecord, vx: float, vy: float, dt_s: float, may_slide: bool
) -> tuple[float, float]:
    """Limit a person's velocity such that it does not reach the robot within the step."""
    dx, dy = robot.x - me.x, robot.y - me.y
    if abs(dx) + abs(dy) > REACH_M + ROBOT_RADIUS_M:
        return vx, vy
    gap = norm(dx, dy) - me.radius - ROBOT_RADIUS_M - ROBOT_MARGIN_M
    return hold_back(vx, vy, dx, dy, gap / dt_s, may_slide)


@scalar
def _keep_off_all(
    people: Records, i: int, place: Place, robot: RobotRecord, dt_s: float, may_slide: bool
) -> bool:
    """Limit person i's velocity towards all obstacles in reach; return True if it changed."""
    me = people[i]
    vx, vy = me.next_vx, me.next_vy
    stride_m = norm(vx, vy) * dt_s  # never increased by the limits
    for j in range(people.shape[0]):
        other = people[j]
        dx, dy = other.x - me.x, other.y - me.y
        if j == i or other.status != PRESENT or abs(dx) + abs(dy) > REACH_M:
            continue
        gap = norm(dx, dy) - me.radius - other.radius
        vx, vy = hold_back(vx, vy, dx, dy, 0.5 * gap / dt_s, may_slide)
    vx, vy = keep_off_robot(me, robot, vx, vy, dt_s, may_slide)
    for k in range(place.walls.shape[0]):
        x1, y1, x2, y2 = place.walls[k, 0], place.walls[k, 1], place.walls[k, 2], place.walls[k, 3]
        if not may_be_near(me.x, me.y, x1, y1, x2, y2, me.radius + stride_m):
            continue
        wx, wy = nearest_on_segment(me.x, me.y, x1, y1, x2, y2)
        dx, dy = wx - me.x, wy - me.y
        if abs(dx) + abs(dy) <= REACH_M:
            gap = norm(dx, dy) - me.radius
            vx, vy = hold_back(vx, vy, dx, dy, gap / dt_s, may_slide)
    is_changed: bool = vx != me.next_vx or vy != me.next_vy
    me.next_vx = vx
    me.next_vy = vy
    return is_changed


@scalar
def keep_apart(people: Records, i: int, place: Place, robot: RobotRecord, dt_s: float) -> None:
    """Limit person i's next velocity towards bodies and walls within the step.

    The person slides along each obstacle in turn, and slows down if sliding leads into another
    obstacle.
    """
    if _keep_off_all(people, i, place, robot, dt_s, True):
        _keep_off_all(people, i, place, robot, dt_s, False)
