"""How people move: one social step turns their state into velocities that hold until the next.

Three models share one record type: scripted walkers stay on their route whatever happens,
social-force walkers answer to people, walls and the robot, and replayed people follow a recording.
People pick their velocities simultaneously, from everybody's old ones.

Forces are soft; on top of them nobody walks into a body or a wall that is in plain reach: the part
of the new velocity that would do so is taken away (``_hold_back``). A robot can still drive into
people.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.geometry import nearest_on_segment, route_pose
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
from hazbot_gym.core.state import (
    GONE,
    PRESENT,
    REPLAY,
    ROBOT_RADIUS_M,
    SCRIPTED,
    WAITING,
    Floats,
    Place,
    Record,
    Records,
)

LOOK_AHEAD_M = 1.0  # how far ahead on the route people aim
SIDESTEP_LENGTH_M = 1.5  # over which a scripted walker changes its lane
ENTRY_ROOM_M = 0.7  # nobody enters where somebody stands within this distance
ROBOT_ENTRY_ROOM_M = 2.0  # nor this near to the robot
ROBOT_MARGIN_M = 0.05  # clearance that people keep from the robot when they can
CATCH_UP_MPS = 2.5  # how fast a replayed person who went round the robot returns to its track
BLOCKING_RANGE_M = 2.0  # clearance within which the robot can stand in somebody's way
NEIGHBOUR_RANGE_M = 5.0  # people farther away than this push by less than 1e-5 m/s^2


@scalar
def lane_offset(person: Record, s: float) -> float:
    """Return the lateral offset of a walker's lane at arc length s, a smooth step when it steps aside."""
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
def _hold_back(vx: float, vy: float, nx: float, ny: float, limit_mps: float) -> tuple[float, float]:
    """Return the velocity without what it has along n beyond a limit."""
    excess = vx * nx + vy * ny - limit_mps
    if excess <= 0.0:
        return vx, vy
    return vx - excess * nx, vy - excess * ny


@scalar
def _is_clear(people: Records, i: int, robot: Record) -> bool:
    """Tell whether there is room for person i to enter."""
    me = people[i]
    if math.hypot(robot.x - me.x, robot.y - me.y) < ROBOT_ENTRY_ROOM_M:
        return False
    for j in range(people.shape[0]):
        other = people[j]
        if other.status == PRESENT and math.hypot(other.x - me.x, other.y - me.y) < ENTRY_ROOM_M:
            return False
    return True


@scalar
def _acceleration(
    people: Records, i: int, place: Place, robot: Record, force: SocialForce, reaction: Reaction
) -> tuple[float, float, float, float]:
    """Return the social acceleration of person i [m/s^2] and its walking direction e."""
    me = people[i]
    aim_x, aim_y = lane_point(place.routes, me, me.s + LOOK_AHEAD_M)
    distance = max(math.hypot(aim_x - me.x, aim_y - me.y), 1e-6)
    ex, ey = (aim_x - me.x) / distance, (aim_y - me.y) / distance
    ax, ay = goal_force(me.vx, me.vy, ex, ey, me.desired_speed, force.relaxation_time_s)

    for j in range(people.shape[0]):
        other = people[j]
        rx, ry = me.x - other.x, me.y - other.y
        if j == i or other.status != PRESENT or abs(rx) + abs(ry) > NEIGHBOUR_RANGE_M:
            continue
        distance = max(math.hypot(rx, ry), 1e-6)
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

    for k in range(place.walls.shape[0]):
        wx, wy = nearest_on_segment(
            me.x, me.y, place.walls[k, 0], place.walls[k, 1], place.walls[k, 2], place.walls[k, 3]
        )
        distance = max(math.hypot(me.x - wx, me.y - wy), 1e-6)
        fx, fy = wall_force(
            (me.x - wx) / distance,
            (me.y - wy) / distance,
            distance - me.radius,
            force.wall_strength_mps2,
            force.wall_range_m,
        )
        ax += fx
        ay += fy

    fx, fy = _robot_acceleration(me, robot, ex, ey, force, reaction)
    return ax + fx, ay + fy, ex, ey


@scalar
def _robot_acceleration(
    me: Record, robot: Record, ex: float, ey: float, force: SocialForce, reaction: Reaction
) -> tuple[float, float]:
    """Return what the robot makes a person do [m/s^2]; nothing before it is noticed."""
    rx, ry = me.x - robot.x, me.y - robot.y
    distance = max(math.hypot(rx, ry), 1e-6)
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
    if (
        robot_vx * ex + robot_vy * ey < 0.5 * me.desired_speed
    ):  # in the way: standing, slow or head-on
        fx, fy = sidestep_force(-rx, -ry, ex, ey, gap, force)
        ax += fx
        ay += fy
    if gap > PERSONAL_M:
        ax -= reaction.attraction_mps2 * rx / distance
        ay -= reaction.attraction_mps2 * ry / distance
    return ax, ay


@scalar
def _keep_off_robot(
    me: Record, robot: Record, vx: float, vy: float, dt_s: float
) -> tuple[float, float]:
    """Return a person's velocity without what would lead it into the robot within the step."""
    dx, dy = robot.x - me.x, robot.y - me.y
    distance = max(math.hypot(dx, dy), 1e-6)
    gap = max(distance - me.radius - ROBOT_RADIUS_M - ROBOT_MARGIN_M, 0.0)
    return _hold_back(vx, vy, dx / distance, dy / distance, gap / dt_s)


@scalar
def _keep_apart(people: Records, i: int, place: Place, robot: Record, dt_s: float) -> None:
    """Take away what of person i's new velocity would lead into a body or a wall within the step."""
    me = people[i]
    vx, vy = me.next_vx, me.next_vy
    for j in range(people.shape[0]):
        other = people[j]
        dx, dy = other.x - me.x, other.y - me.y
        if j == i or other.status != PRESENT or abs(dx) + abs(dy) > ENTRY_ROOM_M:
            continue
        distance = max(math.hypot(dx, dy), 1e-6)
        gap = max(distance - me.radius - other.radius, 0.0)
        vx, vy = _hold_back(vx, vy, dx / distance, dy / distance, 0.5 * gap / dt_s)
    vx, vy = _keep_off_robot(me, robot, vx, vy, dt_s)
    for k in range(place.walls.shape[0]):
        wx, wy = nearest_on_segment(
            me.x, me.y, place.walls[k, 0], place.walls[k, 1], place.walls[k, 2], place.walls[k, 3]
        )
        dx, dy = wx - me.x, wy - me.y
        distance = max(math.hypot(dx, dy), 1e-6)
        gap = max(distance - me.radius, 0.0)
        vx, vy = _hold_back(vx, vy, dx / distance, dy / distance, gap / dt_s)
    me.next_vx = vx
    me.next_vy = vy


@scalar
def _blocked(me: Record, robot: Record, ex: float, ey: float) -> float:
    """Return the share of its desired speed that a person loses while the robot is in its way."""
    rx, ry = robot.x - me.x, robot.y - me.y
    distance = math.hypot(rx, ry)
    gap = distance - me.radius - ROBOT_RADIUS_M
    if gap > BLOCKING_RANGE_M or rx * ex + ry * ey < 0.5 * distance or me.desired_speed <= 0.0:
        return 0.0
    return min(max(1.0 - (me.vx * ex + me.vy * ey) / me.desired_speed, 0.0), 1.0)


@scalar
def _walk(
    people: Records, i: int, place: Place, robot: Record, force: SocialForce, reactions: Records,
    key: np.uint64, step: int, dt_s: float,
) -> None:  # fmt: skip
    """Set the next velocity of a social-force walker."""
    me = people[i]
    ax, ay, ex, ey = _acceleration(people, i, place, robot, force, reactions[me.reaction])
    u1, u2, _, _ = uniform4(key, CROWD, step, i)
    n1, n2 = normal_pair(u1, u2)
    vx = me.vx + (ax + force.jitter_mps2 * n1) * dt_s
    vy = me.vy + (ay + force.jitter_mps2 * n2) * dt_s
    speed = math.hypot(vx, vy)
    limit = force.speed_limit_ratio * me.desired_speed
    if speed > limit:
        vx *= limit / speed
        vy *= limit / speed
    me.blocked = _blocked(me, robot, ex, ey)
    me.next_vx = vx
    me.next_vy = vy
    _keep_apart(people, i, place, robot, dt_s)


@scalar
def _follow_script(me: Record, routes: Floats, dt_s: float) -> None:
    """Set the next velocity of a scripted walker, so that it ends the step on its lane."""
    x, y = lane_point(routes, me, me.s + me.desired_speed * dt_s)
    me.next_vx = (x - me.x) / dt_s
    me.next_vy = (y - me.y) / dt_s


@scalar
def _follow_recording(me: Record, robot: Record, recording: Floats, step: int, dt_s: float) -> None:
    """Set the next velocity of a replayed person; NaN in the recording means absent.

    People walk as recorded, but round a robot that stands in their way: nobody there had one to
    see.
    """
    if step + 1 >= recording.shape[0]:
        me.status = GONE
        return
    if math.isnan(recording[step, me.route, 0]) or math.isnan(recording[step + 1, me.route, 0]):
        me.status = WAITING
        return
    if me.status != PRESENT:
        me.x, me.y = recording[step, me.route, 0], recording[step, me.route, 1]
        if math.hypot(robot.x - me.x, robot.y - me.y) < me.radius + ROBOT_RADIUS_M + ROBOT_MARGIN_M:
            return
        me.status = PRESENT
    vx = (recording[step + 1, me.route, 0] - me.x) / dt_s
    vy = (recording[step + 1, me.route, 1] - me.y) / dt_s
    speed = math.hypot(vx, vy)
    if speed > CATCH_UP_MPS:
        vx *= CATCH_UP_MPS / speed
        vy *= CATCH_UP_MPS / speed
    me.next_vx, me.next_vy = _keep_off_robot(me, robot, vx, vy, dt_s)
    me.desired_speed = min(speed, CATCH_UP_MPS)


@scalar
def _enter(people: Records, i: int, robot: Record, time_s: float) -> None:
    """Let a waiting person in when its time has come; reacting people wait until there is room."""
    me = people[i]
    if time_s < me.enters_s - 1e-9:
        return
    if me.model == SCRIPTED or _is_clear(people, i, robot):
        me.status = PRESENT


@scalar
def _advance(me: Record, routes: Floats, dt_s: float) -> None:
    """Note how far a walker has come on its route since the last social step; at the end it is gone."""
    if me.model == SCRIPTED:
        me.s += me.desired_speed * dt_s
    else:
        x, y, tx, ty = route_pose(routes, me.route, me.s)
        me.s = max(me.s + (me.x - x) * tx + (me.y - y) * ty, 0.0)
    if me.s >= routes[me.route, routes.shape[1] - 1, 2]:
        me.status = GONE


@scalar
def social_step(
    people: Records, place: Place, robot: Record, force: SocialForce, reactions: Records,
    recording: Floats, key: np.uint64, step: int, dt_s: float,
) -> None:  # fmt: skip
    """Give every person the velocity that it keeps for the next social period.

    Args:
        people: (P,) PERSON records, changed in place.
        place: Walls and routes.
        robot: The robot's record.
        force: Constants of the walking model (a record with the fields of ``SocialForce``).
        reactions: (4,) records of ``Reaction``.
        recording: (T, P, 2) positions at every social step [m], NaN where absent; for REPLAY only.
        key: Key of the scenario's noise.
        step: Number of this social step since the reset.
        dt_s: Social period [s].
    """
    for i in range(people.shape[0]):
        me = people[i]
        if me.model != REPLAY and me.status == PRESENT and step > 0:
            _advance(me, place.routes, dt_s)
        if me.model != REPLAY and me.status == WAITING:
            _enter(people, i, robot, step * dt_s)
    for i in range(people.shape[0]):
        me = people[i]
        if me.model == REPLAY:
            _follow_recording(me, robot, recording, step, dt_s)
        elif me.status == PRESENT:
            if me.model == SCRIPTED:
                _follow_script(me, place.routes, dt_s)
            else:
                _walk(people, i, place, robot, force, reactions, key, step, dt_s)
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            me.vx = me.next_vx
            me.vy = me.next_vy
        else:
            me.vx = 0.0
            me.vy = 0.0


@scalar
def move_people(people: Records, dt_s: float) -> None:
    """Move everybody present at the present velocity for a physics step's or social period's time."""
    for i in range(people.shape[0]):
        me = people[i]
        if me.status == PRESENT:
            me.x += me.vx * dt_s
            me.y += me.vy * dt_s
