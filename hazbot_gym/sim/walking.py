"""Social force model of a walker among people, walls and a robot.

    dv/dt = (v0 e - v)/tau + v0/v_typical (f_people + f_walls + f_robot + fluctuation)

The forces are those of ``core.social_force``; e points to the walker's lane ahead. Their constants
hold for people at a typical walking speed. Forces scale with the desired speed, so that slow
walkers take the same route around a robot instead of being pushed away.
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
from hazbot_gym.core.state import ROBOT_RADIUS_M, Floats, PersonRecord

LOOK_AHEAD_M = 1.0  # look-ahead distance on the lane
SIDESTEP_LENGTH_M = 1.5  # distance of a scripted lane change
BLOCKING_RANGE_M = 2.0  # clearance within which the robot can block a walker
WALL_REACH = 7.0  # ranges of the wall force beyond which it is neglected (1e-3 of its strength)
# Interaction range: |x| + |y| at most this; the force of people who do not approach is below 0.05
# m/s^2 beyond the second range already.
NEIGHBOUR_RANGE_M, RECEDING_RANGE_M = 5.0, 3.0

# --- the lane ------------------------------------------------------------------------------------


@scalar
def lane_offset(person: PersonRecord, s: float) -> float:
    """Return the lateral offset of a walker's lane at arc length s, with smooth lane changes."""
    t = 1.0 + (s - person.sidestep_s) / SIDESTEP_LENGTH_M
    if t <= 0.0:
        return float(person.offset)
    if t >= 1.0:
        return float(person.sidestep_offset)
    return float(person.offset + (person.sidestep_offset - person.offset) * t * t * (3.0 - 2.0 * t))


@scalar
def lane_point(routes: Floats, person: PersonRecord, s: float) -> tuple[float, float]:
    """Return the point of a walker's lane at arc length s."""
    x, y, tx, ty = route_pose(routes, person.route, s)
    offset = lane_offset(person, s)
    return x - offset * ty, y + offset * tx


@scalar
def walking_direction(me: PersonRecord, routes: Floats) -> tuple[float, float]:
    """Return the unit vector e to a walker's target point ahead on its lane."""
    x, y = lane_point(routes, me, me.s + LOOK_AHEAD_M)
    per_m = 1.0 / max(norm(x - me.x, y - me.y), 1e-6)
    return per_m * (x - me.x), per_m * (y - me.y)


# --- the forces ----------------------------------------------------------------------------------


@scalar
def body_push(
    x: float, y: float, vx: float, vy: float, reach: float, ex: float, ey: float,
    strength: float, range_m: float, step_time_s: float, gain: float, sidestep_mps2: float,
    force: SocialForce,
) -> tuple[float, float]:  # fmt: skip
    """Return the acceleration of a walker by another body [m/s^2].

    Args:
        x: From the other's centre to the walker's [m].
        y: The same, other axis [m].
        vx: The walker's velocity relative to the other [m/s].
        vy: The same, other axis [m/s].
        reach: Sum of the radii [m].
        ex: Walking direction, unit vector.
        ey: The same, other axis.
        strength: Strength of the repulsion [m/s^2].
        range_m: Range of the repulsion [m].
        step_time_s: Anticipated time of the relative motion [s].
        gain: Factor of the repulsion.
        sidestep_mps2: Strength of the side step; 0 if the other is not in the way [m/s^2].
        force: Constants of the model.
    """
    distance = max(norm(x, y), 1e-6)
    gap = max(distance - reach, 0.01)
    nx, ny = x / distance, y / distance
    sx, sy = -step_time_s * vx, -step_time_s * vy
    fx, fy = elliptical_repulsion(nx, ny, gap, sx, sy, strength, range_m)
    weight = gain * view_weight(ex, ey, fx, fy, force)
    aside_x, aside_y = sidestep_force(-nx, -ny, ex, ey, gap, sidestep_mps2, force.sidestep_range_m)
    return weight * fx + aside_x, weight * fy + aside_y


@scalar
def robot_push(
    x: float, y: float, vx: float, vy: float, robot_vx: float, robot_vy: float,
    desired_speed: float, radius: float, ex: float, ey: float, reaction: Reaction,
    force: SocialForce,
) -> tuple[float, float]:  # fmt: skip
    """Return the acceleration by the robot at relative (x, y); 0 before it is noticed."""
    distance = max(norm(x, y), 1e-6)
    gap = max(distance - radius - ROBOT_RADIUS_M, 0.01)
    is_in_the_way = robot_vx * ex + robot_vy * ey < 0.5 * desired_speed  # stands, slow, head-on
    ax, ay = body_push(
        -x, -y, vx - robot_vx, vy - robot_vy, radius + ROBOT_RADIUS_M, ex, ey,
        force.robot_strength_mps2, force.robot_range_m, force.robot_step_time_s, reaction.gain,
        force.robot_sidestep_mps2 if is_in_the_way else 0.0, force,
    )  # fmt: skip
    pull = reaction.attraction_mps2 / distance if gap > PERSONAL_M else 0.0
    is_noticed = gap <= reaction.range_m
    return (ax + pull * x if is_noticed else 0.0), (ay + pull * y if is_noticed else 0.0)


@scalar
def blocked_share(
    x: float, y: float, along_mps: float, desired_speed: float, radius: float, ex: float, ey: float
) -> float:
    """Return the relative loss of desired speed while the robot blocks a walker."""
    distance = norm(x, y)
    gap = distance - radius - ROBOT_RADIUS_M
    is_ahead = gap <= BLOCKING_RANGE_M and x * ex + y * ey >= 0.5 * distance
    lost = min(max(1.0 - along_mps / max(desired_speed, 1e-9), 0.0), 1.0)
    return lost if is_ahead and desired_speed > 0.0 else 0.0
