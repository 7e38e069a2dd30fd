"""How a social-force walker chooses its velocity among people, walls and a robot.

    dv/dt = (v0 e - v)/tau + v0/v_typical (f_people + f_walls + f_robot + fluctuation)

The forces are those of ``core.social_force``; e points to the walker's lane ahead. Their constants
hold for people who walk at a typical speed. Slower ones answer in proportion, so that a stroller
takes the same way round a robot as anybody else, instead of being driven off by forces far beyond
its own.
"""

from __future__ import annotations

from hazbot_gym.core.geometry import norm, route_pose
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.proxemics import PERSONAL_M
from hazbot_gym.core.social_force import (
    Reaction,
    SocialForce,
    elliptical_repulsion,
    sidestep_force,
    view_weight,
)
from hazbot_gym.core.state import ROBOT_RADIUS_M, Floats, Record

LOOK_AHEAD_M = 1.0  # how far ahead on the lane people aim
SIDESTEP_LENGTH_M = 1.5  # over which a scripted walker changes its lane
BLOCKING_RANGE_M = 2.0  # clearance within which the robot can stand in somebody's way
WALL_REACH = 7.0  # ranges of the wall force beyond which it is nil (1e-3 of its strength)
# People are answered to while |x| + |y| is at most this; those who come no nearer push by less than
# 0.05 m/s^2 beyond the second range already.
NEIGHBOUR_RANGE_M, RECEDING_RANGE_M = 5.0, 3.0

# --- the way -------------------------------------------------------------------------------------


@scalar
def lane_offset(person: Record, s: float) -> float:
    """Return the lateral offset of a walker's lane at arc length s; it steps aside smoothly."""
    t = 1.0 + (s - person.sidestep_s) / SIDESTEP_LENGTH_M
    if t <= 0.0:
        return float(person.offset)
    if t >= 1.0:
        return float(person.sidestep_offset)
    return float(person.offset + (person.sidestep_offset - person.offset) * t * t * (3.0 - 2.0 * t))


@scalar
def lane_point(routes: Floats, person: Record, s: float) -> tuple[float, float]:
    """Return where a walker's lane runs at arc length s."""
    x, y, tx, ty = route_pose(routes, person.route, s)
    offset = lane_offset(person, s)
    return x - offset * ty, y + offset * tx


@scalar
def walking_direction(me: Record, routes: Floats) -> tuple[float, float]:
    """Return the unit vector e to the point ahead on its lane that a walker aims at."""
    x, y = lane_point(routes, me, me.s + LOOK_AHEAD_M)
    per_m = 1.0 / max(norm(x - me.x, y - me.y), 1e-6)
    return per_m * (x - me.x), per_m * (y - me.y)


# --- the forces ----------------------------------------------------------------------------------


@scalar
def body_push(
    x: float, y: float, vx: float, vy: float, reach: float, ex: float, ey: float,
    strength: float, range_m: float, gain: float, is_in_the_way: bool, force: SocialForce,
) -> tuple[float, float]:  # fmt: skip
    """Return what another body makes a walker do [m/s^2].

    Args:
        x: From the other's centre to one's own [m].
        y: The same, other axis [m].
        vx: One's own velocity relative to the other's [m/s].
        vy: The same, other axis [m/s].
        reach: Sum of the radii [m].
        ex: Walking direction, unit vector.
        ey: The same, other axis.
        strength: Of the repulsion [m/s^2].
        range_m: Of the repulsion [m].
        gain: Multiplies it.
        is_in_the_way: Whether to step aside besides.
        force: Constants of the model.
    """
    distance = max(norm(x, y), 1e-6)
    gap = max(distance - reach, 0.01)
    nx, ny = x / distance, y / distance
    sx, sy = -force.step_time_s * vx, -force.step_time_s * vy
    fx, fy = elliptical_repulsion(nx, ny, gap, sx, sy, strength, range_m)
    weight = gain * view_weight(ex, ey, fx, fy, force)
    aside_x, aside_y = sidestep_force(-nx, -ny, ex, ey, gap, force)
    aside = 1.0 if is_in_the_way else 0.0
    return weight * fx + aside * aside_x, weight * fy + aside * aside_y


@scalar
def robot_push(
    x: float, y: float, vx: float, vy: float, robot_vx: float, robot_vy: float,
    desired_speed: float, radius: float, ex: float, ey: float, reaction: Reaction,
    force: SocialForce,
) -> tuple[float, float]:  # fmt: skip
    """Return what the robot at (x, y) from here makes a walker do; nothing before it is noticed."""
    distance = max(norm(x, y), 1e-6)
    gap = max(distance - radius - ROBOT_RADIUS_M, 0.01)
    is_in_the_way = robot_vx * ex + robot_vy * ey < 0.5 * desired_speed  # stands, slow, head-on
    ax, ay = body_push(
        -x, -y, vx - robot_vx, vy - robot_vy, radius + ROBOT_RADIUS_M, ex, ey,
        force.robot_strength_mps2, force.robot_range_m, reaction.gain, is_in_the_way, force,
    )  # fmt: skip
    pull = reaction.attraction_mps2 / distance if gap > PERSONAL_M else 0.0
    is_noticed = gap <= reaction.range_m
    return (ax + pull * x if is_noticed else 0.0), (ay + pull * y if is_noticed else 0.0)


@scalar
def blocked_share(
    x: float, y: float, along_mps: float, desired_speed: float, radius: float, ex: float, ey: float
) -> float:
    """Return the share of its desired speed that a walker loses while the robot is in its way."""
    distance = norm(x, y)
    gap = distance - radius - ROBOT_RADIUS_M
    is_ahead = gap <= BLOCKING_RANGE_M and x * ex + y * ey >= 0.5 * distance
    lost = min(max(1.0 - along_mps / max(desired_speed, 1e-9), 0.0), 1.0)
    return lost if is_ahead and desired_speed > 0.0 else 0.0
