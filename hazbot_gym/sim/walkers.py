"""Vectorized social-force walkers, of one or many worlds.

Social-force walkers are loaded from their worlds into lanes of a workspace. First the pairs within
interaction range are collected; then all forces and velocities are computed, and the results
stored. No walker's result depends on other walkers in the workspace. As in ``lanes.py`` the loops
over lanes compile to vector instructions.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.geometry import may_be_near, nearest_on_segment, norm
from hazbot_gym.core.jit import LANES, routine, scalar
from hazbot_gym.core.noise import CROWD, uniform4, uniform_noise
from hazbot_gym.core.social_force import Reaction, SocialForce, goal_force, wall_force
from hazbot_gym.core.state import (
    PRESENT,
    Floats,
    Ints,
    PersonRecord,
    Place,
    Records,
    RobotRecord,
    records,
)
from hazbot_gym.sim.spacing import keep_apart
from hazbot_gym.sim.walking import (
    NEIGHBOUR_RANGE_M,
    RECEDING_RANGE_M,
    WALL_REACH,
    blocked_share,
    body_push,
    robot_push,
    walking_direction,
)

_EACH = ("f8", (LANES,))
WALKERS = np.dtype(
    [
        *((name, *_EACH) for name in ("vx", "vy", "ex", "ey", "radius", "desired_speed")),
        *((name, *_EACH) for name in ("robot_x", "robot_y", "robot_vx", "robot_vy")),  # from me
        *((name, *_EACH) for name in ("gain", "range_m", "attraction_mps2")),  # the reaction
        ("key", "u8", (LANES,)),
        ("step", "i8", (LANES,)),
        ("person", "i8", (LANES,)),
        # Forces of people and walls, separately, so that sums do not depend on other walkers.
        *((name, "f8", (2, LANES)) for name in ("ax", "ay")),
        *((name, *_EACH) for name in ("next_vx", "next_vy", "blocked")),  # chosen velocity
    ],
    align=True,
)
PUSHES = np.dtype(
    [
        ("count", "i8"),  # lanes in use
        ("walker", "i8", (LANES,)),  # index of the pushed walker
        *((name, *_EACH) for name in ("x", "y", "vx", "vy")),  # relative to the other
        *((name, *_EACH) for name in ("reach", "ex", "ey", "is_head_on")),
        *((name, *_EACH) for name in ("x1", "y1", "x2", "y2")),  # of a wall, relative to the walker
        *((name, *_EACH) for name in ("fx", "fy")),
    ],
    align=True,
)


class WalkersRecord(Protocol):
    """One element of an array of ``WALKERS``; all fields are arrays over lanes."""

    vx: Floats
    vy: Floats
    ex: Floats
    ey: Floats
    radius: Floats
    desired_speed: Floats
    robot_x: Floats
    robot_y: Floats
    robot_vx: Floats
    robot_vy: Floats
    gain: Floats
    range_m: Floats
    attraction_mps2: Floats
    key: npt.NDArray[np.uint64]
    step: Ints
    person: Ints
    ax: Floats
    ay: Floats
    next_vx: Floats
    next_vy: Floats
    blocked: Floats


class PushesRecord(Protocol):
    """One element of an array of ``PUSHES``; all fields but the count are arrays over lanes."""

    count: int
    walker: Ints
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    reach: Floats
    ex: Floats
    ey: Floats
    is_head_on: Floats
    x1: Floats
    y1: Floats
    x2: Floats
    y2: Floats
    fx: Floats
    fy: Floats


BY_PEOPLE, BY_WALLS = 0, 1  # source of the force


class Workspace(NamedTuple):
    """Workspace of the vectorized walker update."""

    walkers: Records  # (C,) WALKERS
    pushes: Records  # (2,) PUSHES by people and by walls


def make_workspace(walkers: int) -> Workspace:
    """Return a workspace for a number of walkers."""
    chunks = max(-(-walkers // LANES), 1)
    return Workspace(records(WALKERS, chunks), records(PUSHES, 2))


# --- loading -------------------------------------------------------------------------------------


@scalar
def take_up(
    work: Workspace, w: int, people: Records, i: int, place: Place, robot: RobotRecord,
    robot_vx: float, robot_vy: float, force: SocialForce, reaction: Reaction, key: np.uint64,
    step: int,
) -> None:  # fmt: skip
    """Load person i as walker w, and collect its neighbours and walls.

    Args:
        work: Workspace, changed in place.
        w: Number of the walker: 0 for the first, and so on.
        people: (P,) PERSON records of its world.
        i: Index of the person.
        place: Walls and routes.
        robot: The robot's record.
        robot_vx: Velocity of the robot, world axes [m/s].
        robot_vy: The same, other axis [m/s].
        force: Constants of the walking model.
        reaction: Reaction of the person to the robot.
        key: Key of the scenario's noise.
        step: Number of this social step since the reset.
    """
    me, lane, chunk = people[i], w % LANES, work.walkers[w // LANES]
    chunk.ex[lane], chunk.ey[lane] = walking_direction(me, place.routes)
    chunk.vx[lane], chunk.vy[lane] = me.vx, me.vy
    chunk.radius[lane], chunk.desired_speed[lane] = me.radius, me.desired_speed
    chunk.robot_x[lane], chunk.robot_y[lane] = robot.x - me.x, robot.y - me.y
    chunk.robot_vx[lane], chunk.robot_vy[lane] = robot_vx, robot_vy
    chunk.gain[lane], chunk.range_m[lane] = reaction.gain, reaction.range_m
    chunk.attraction_mps2[lane] = reaction.attraction_mps2
    chunk.key[lane], chunk.step[lane], chunk.person[lane] = key, step, i
    for source in (BY_PEOPLE, BY_WALLS):
        chunk.ax[source, lane], chunk.ay[source, lane] = 0.0, 0.0
    _note_people(work, w, people, i, force)
    _note_walls(work, w, me, place.walls, force)


@scalar
def _note_people(work: Workspace, w: int, people: Records, i: int, force: SocialForce) -> None:
    """Collect the people near person i, walker w."""
    me, pushes = people[i], work.pushes[BY_PEOPLE]
    lane, chunk = w % LANES, work.walkers[w // LANES]
    ex, ey = chunk.ex[lane], chunk.ey[lane]
    for j in range(people.shape[0]):
        other = people[j]
        x, y, vx, vy = me.x - other.x, me.y - other.y, me.vx - other.vx, me.vy - other.vy
        range_m = NEIGHBOUR_RANGE_M if x * vx + y * vy < 0.0 else RECEDING_RANGE_M
        if j == i or other.status != PRESENT or abs(x) + abs(y) > range_m:
            continue
        k = pushes.count
        pushes.walker[k], pushes.x[k], pushes.y[k] = w, x, y
        pushes.vx[k], pushes.vy[k] = vx, vy
        pushes.reach[k], pushes.ex[k], pushes.ey[k] = me.radius + other.radius, ex, ey
        pushes.is_head_on[k] = 1.0 if other.vx * ex + other.vy * ey < 0.0 else 0.0
        pushes.count = k + 1
        if k + 1 == LANES:
            push_by_people(work, force)


@scalar
def _note_walls(
    work: Workspace, w: int, me: PersonRecord, walls: Floats, force: SocialForce
) -> None:
    """Collect the walls near walker w."""
    pushes, reach = work.pushes[BY_WALLS], me.radius + WALL_REACH * force.wall_range_m
    for i in range(walls.shape[0]):
        if not may_be_near(me.x, me.y, walls[i, 0], walls[i, 1], walls[i, 2], walls[i, 3], reach):
            continue
        k = pushes.count
        pushes.walker[k], pushes.reach[k] = w, me.radius
        pushes.x1[k], pushes.y1[k] = walls[i, 0] - me.x, walls[i, 1] - me.y
        pushes.x2[k], pushes.y2[k] = walls[i, 2] - me.x, walls[i, 3] - me.y
        pushes.count = k + 1
        if k + 1 == LANES:
            push_by_walls(work, force)


# --- the forces ----------------------------------------------------------------------------------


@scalar
def force_values(force: SocialForce) -> SocialForce:
    """Return the constants as values, which the compiler can keep in registers."""
    return SocialForce(
        force.relaxation_time_s, force.typical_speed_mps, force.speed_limit_ratio,
        force.person_strength_mps2, force.person_range_m, force.step_time_s,
        force.wall_strength_mps2, force.wall_range_m, force.robot_strength_mps2,
        force.robot_range_m, force.robot_step_time_s, force.robot_sidestep_mps2,
        force.anisotropy, force.view_angle_rad, force.sidestep_mps2, force.sidestep_range_m,
        force.jitter_mps2,
    )  # fmt: skip


@routine
def push_by_people(work: Workspace, force: SocialForce) -> None:
    """Compute the collected forces by people, and clear the list."""
    p = work.pushes[BY_PEOPLE]
    for k in range(LANES):
        p.fx[k], p.fy[k] = body_push(
            p.x[k], p.y[k], p.vx[k], p.vy[k], p.reach[k], p.ex[k], p.ey[k],
            force.person_strength_mps2, force.person_range_m, force.step_time_s, 1.0,
            force.sidestep_mps2 * p.is_head_on[k], force,
        )  # fmt: skip
    _add_up(p, BY_PEOPLE, work.walkers)


@routine
def push_by_walls(work: Workspace, force: SocialForce) -> None:
    """Compute the collected forces by walls, and clear the list."""
    p = work.pushes[BY_WALLS]
    for k in range(LANES):
        x, y = nearest_on_segment(0.0, 0.0, p.x1[k], p.y1[k], p.x2[k], p.y2[k])
        distance = max(norm(x, y), 1e-6)
        fx, fy = wall_force(
            -x / distance, -y / distance, distance - p.reach[k],
            force.wall_strength_mps2, force.wall_range_m,
        )  # fmt: skip
        is_near = distance <= p.reach[k] + WALL_REACH * force.wall_range_m
        p.fx[k] = fx if is_near else 0.0
        p.fy[k] = fy if is_near else 0.0
    _add_up(p, BY_WALLS, work.walkers)


@scalar
def _add_up(pushes: PushesRecord, source: int, walkers: Records) -> None:
    for k in range(pushes.count):
        w = pushes.walker[k]
        walkers[w // LANES].ax[source, w % LANES] += pushes.fx[k]
        walkers[w // LANES].ay[source, w % LANES] += pushes.fy[k]
    pushes.count = 0


# --- the velocity --------------------------------------------------------------------------------


@routine
def walk(work: Workspace, count: int, force: SocialForce, dt_s: float) -> None:
    """Compute the desired velocity after dt of the first walkers of a workspace."""
    push_by_people(work, force)
    push_by_walls(work, force)
    for k in range((count + LANES - 1) // LANES):
        _choose(work.walkers[k], force, dt_s)


@scalar
def _choose(c: WalkersRecord, force: SocialForce, dt_s: float) -> None:
    for k in range(LANES):
        u1, u2, _, _ = uniform4(c.key[k], CROWD, c.step[k], c.person[k])
        c.next_vx[k] = force.jitter_mps2 * uniform_noise(u1)
        c.next_vy[k] = force.jitter_mps2 * uniform_noise(u2)
    for k in range(LANES):
        reaction = Reaction(c.gain[k], c.range_m[k], c.attraction_mps2[k])
        rx, ry = robot_push(
            c.robot_x[k], c.robot_y[k], c.vx[k], c.vy[k], c.robot_vx[k], c.robot_vy[k],
            c.desired_speed[k], c.radius[k], c.ex[k], c.ey[k], reaction, force,
        )  # fmt: skip
        c.next_vx[k] += c.ax[BY_PEOPLE, k] + c.ax[BY_WALLS, k] + rx
        c.next_vy[k] += c.ay[BY_PEOPLE, k] + c.ay[BY_WALLS, k] + ry
    for k in range(LANES):
        speed, ex, ey = c.desired_speed[k], c.ex[k], c.ey[k]
        gx, gy = goal_force(c.vx[k], c.vy[k], ex, ey, speed, force.relaxation_time_s)
        pace = speed / force.typical_speed_mps
        vx = c.vx[k] + (gx + pace * c.next_vx[k]) * dt_s
        vy = c.vy[k] + (gy + pace * c.next_vy[k]) * dt_s
        excess = max(norm(vx, vy) / max(force.speed_limit_ratio * speed, 1e-9), 1.0)
        c.next_vx[k], c.next_vy[k] = vx / excess, vy / excess
        along_mps = c.vx[k] * ex + c.vy[k] * ey
        c.blocked[k] = blocked_share(
            c.robot_x[k], c.robot_y[k], along_mps, speed, c.radius[k], ex, ey
        )


@scalar
def put_down(
    work: Workspace, w: int, people: Records, i: int, place: Place, robot: RobotRecord, dt_s: float
) -> None:
    """Store walker w's velocity to person i, limited towards obstacles."""
    me, lane, chunk = people[i], w % LANES, work.walkers[w // LANES]
    me.blocked = chunk.blocked[lane]
    me.next_vx, me.next_vy = chunk.next_vx[lane], chunk.next_vy[lane]
    keep_apart(people, i, place, robot, dt_s)
