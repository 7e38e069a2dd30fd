"""How a social-force walker chooses its velocity among people, walls and a robot.

    dv/dt = (v0 e - v)/tau + v0/v_typical (f_people + f_walls + f_robot + fluctuation)

The forces are those of ``core.social_force``; e points to the walker's lane ahead. Their constants
hold for people who walk at a typical speed. Slower ones answer in proportion, so that a stroller
takes the same way round a robot as anybody else, instead of being driven off by forces far beyond
its own.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.geometry import nearest_on_segment, norm, route_pose
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.noise import CROWD, normal_pair, uniform4
from hazbot_gym.core.proxemics import PERSONAL_M
from hazbot_gym.core.social_force import (
    Reaction,
    SocialForce,
    elliptical_repulsion,
    goal_force,
    sidestep_force,
    view_weight,
    wall_force,
)
from hazbot_gym.core.state import PRESENT, ROBOT_RADIUS_M, Floats, Place, Record, Records
from hazbot_gym.sim.spacing import keep_apart

LOOK_AHEAD_M = 1.0  # how far ahead on the lane people aim
SIDESTEP_LENGTH_M = 1.5  # over which a scripted walker changes its lane
BLOCKING_RANGE_M = 2.0  # clearance within which the robot can stand in somebody's way
WALL_REACH = 10.0  # ranges of the wall force beyond which it is nil (5e-5 of its strength)
NEIGHBOUR_RANGE_M = 5.0  # people farther away than this push by less than 1e-5 m/s^2

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
    distance = max(norm(x - me.x, y - me.y), 1e-6)
    return (x - me.x) / distance, (y - me.y) / distance


# --- the forces ----------------------------------------------------------------------------------


@scalar
def _people_push(
    people: Records, i: int, ex: float, ey: float, force: SocialForce
) -> tuple[float, float]:
    """Return what the other people make person i do [m/s^2]."""
    me = people[i]
    ax, ay = 0.0, 0.0
    for j in range(people.shape[0]):
        other = people[j]
        rx, ry = me.x - other.x, me.y - other.y
        if j == i or other.status != PRESENT or abs(rx) + abs(ry) > NEIGHBOUR_RANGE_M:
            continue
        distance = max(norm(rx, ry), 1e-6)
        gap = max(distance - me.radius - other.radius, 0.01)
        sx, sy = force.step_time_s * (other.vx - me.vx), force.step_time_s * (other.vy - me.vy)
        fx, fy = elliptical_repulsion(
            rx * gap / distance,
            ry * gap / distance,
            sx,
            sy,
            force.person_strength_mps2,
            force.person_range_m,
        )
        weight = view_weight(ex, ey, fx, fy, force)
        ax += weight * fx
        ay += weight * fy
        if other.vx * ex + other.vy * ey < 0.0:  # head-on
            fx, fy = sidestep_force(-rx, -ry, ex, ey, gap, force)
            ax += fx
            ay += fy
    return ax, ay


@scalar
def _wall_push(me: Record, walls: Floats, force: SocialForce) -> tuple[float, float]:
    """Return what the walls make a person do [m/s^2]."""
    ax, ay = 0.0, 0.0
    for k in range(walls.shape[0]):
        x, y = nearest_on_segment(me.x, me.y, walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3])
        distance = max(norm(me.x - x, me.y - y), 1e-6)
        if distance > me.radius + WALL_REACH * force.wall_range_m:
            continue
        fx, fy = wall_force(
            (me.x - x) / distance,
            (me.y - y) / distance,
            distance - me.radius,
            force.wall_strength_mps2,
            force.wall_range_m,
        )
        ax += fx
        ay += fy
    return ax, ay


@scalar
def _robot_push(
    me: Record, robot: Record, ex: float, ey: float, force: SocialForce, reaction: Reaction
) -> tuple[float, float]:
    """Return what the robot makes a person do [m/s^2]; nothing before it is noticed."""
    rx, ry = me.x - robot.x, me.y - robot.y
    distance = max(norm(rx, ry), 1e-6)
    gap = max(distance - me.radius - ROBOT_RADIUS_M, 0.01)
    if gap > reaction.range_m:
        return 0.0, 0.0
    robot_vx, robot_vy = robot.v * math.cos(robot.theta), robot.v * math.sin(robot.theta)
    sx, sy = force.step_time_s * (robot_vx - me.vx), force.step_time_s * (robot_vy - me.vy)
    fx, fy = elliptical_repulsion(
        rx * gap / distance,
        ry * gap / distance,
        sx,
        sy,
        force.robot_strength_mps2,
        force.robot_range_m,
    )
    weight = reaction.gain * view_weight(ex, ey, fx, fy, force)
    ax, ay = weight * fx, weight * fy
    is_in_the_way = robot_vx * ex + robot_vy * ey < 0.5 * me.desired_speed  # stands, slow, head-on
    if is_in_the_way:
        fx, fy = sidestep_force(-rx, -ry, ex, ey, gap, force)
        ax += fx
        ay += fy
    if gap > PERSONAL_M:
        ax -= reaction.attraction_mps2 * rx / distance
        ay -= reaction.attraction_mps2 * ry / distance
    return ax, ay


# --- the velocity --------------------------------------------------------------------------------


@scalar
def _blocked(me: Record, robot: Record, ex: float, ey: float) -> float:
    """Return the share of its desired speed that a person loses while the robot is in its way."""
    rx, ry = robot.x - me.x, robot.y - me.y
    distance = norm(rx, ry)
    gap = distance - me.radius - ROBOT_RADIUS_M
    if gap > BLOCKING_RANGE_M or rx * ex + ry * ey < 0.5 * distance or me.desired_speed <= 0.0:
        return 0.0
    return min(max(1.0 - (me.vx * ex + me.vy * ey) / me.desired_speed, 0.0), 1.0)


@scalar
def walk(
    people: Records, i: int, place: Place, robot: Record, force: SocialForce, reaction: Reaction,
    key: np.uint64, step: int, dt_s: float,
) -> None:  # fmt: skip
    """Set the next velocity of social-force walker i; ``people.social_step`` has the arguments."""
    me = people[i]
    ex, ey = walking_direction(me, place.routes)
    gx, gy = goal_force(me.vx, me.vy, ex, ey, me.desired_speed, force.relaxation_time_s)
    px, py = _people_push(people, i, ex, ey, force)
    wx, wy = _wall_push(me, place.walls, force)
    rx, ry = _robot_push(me, robot, ex, ey, force, reaction)
    u1, u2, _, _ = uniform4(key, CROWD, step, i)
    n1, n2 = normal_pair(u1, u2)
    pace = me.desired_speed / force.typical_speed_mps
    vx = me.vx + (gx + pace * (px + wx + rx + force.jitter_mps2 * n1)) * dt_s
    vy = me.vy + (gy + pace * (py + wy + ry + force.jitter_mps2 * n2)) * dt_s
    excess = norm(vx, vy) / max(force.speed_limit_ratio * me.desired_speed, 1e-9)
    me.blocked = _blocked(me, robot, ex, ey)
    me.next_vx = vx / max(excess, 1.0)
    me.next_vy = vy / max(excess, 1.0)
    keep_apart(people, i, place, robot, dt_s)
