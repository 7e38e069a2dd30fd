"""Sane people: every contact statistic rests on walkers who mind a robot.

A robot stands still, at the start of its path or farther along it, while drawn social-force people
walk by; a compiled loop watches them at every physics step until the last one has left.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.geometry import (
    nearest_on_segment,
    path_length,
    path_pose,
    segments_cross,
)
from hazbot_gym.core.hooks import NO_HOOK
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.recorded_table import NO_STRETCH
from hazbot_gym.core.state import (
    GONE,
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    Floats,
    Place,
    Records,
    as_record,
    records,
)
from hazbot_gym.sim.people import move_people, social_step
from hazbot_gym.sim.walkers import Workspace, make_workspace
from hazbot_gym.task.scenario import ScenarioSampler

DT_S, SUBSTEPS = 0.05, 5  # social period [s], physics steps in it
LONGEST = 4800  # social periods; the slowest leaders need 3730 for their way
EPISODES = 150
START_ROOM_M = 1.4  # people who are drawn nearer to the robot than this are left out

# Where the robot stands: place, and share of its path. In the doorway itself nobody can pass.
STANDS = [
    *[(place, 0.0) for place in ("corridor", "intersection", "doorway", "circle", "aisle", "open")],
    *[(place, 0.5) for place in ("corridor", "intersection", "circle", "aisle", "open")],
    *[("doorway", 0.25), ("aisle", 0.25), ("aisle", 0.75)],
]

WATCH = np.dtype(
    [
        ("came", "i8"),
        ("arrived", "i8"),
        ("tunnelled", "i8"),  # crossed a wall
        ("robot_gap", "f8"),  # smallest distances between surfaces [m]
        ("people_gap", "f8"),
        ("wall_gap", "f8"),
        ("top", "f8"),  # largest speed / desired speed
        ("walked_s", "f8"),  # time on the route
        ("nominal_s", "f8"),  # the same at the desired speed
        ("last_mps", "f8"),  # speed at the end, if still there
    ],
    align=True,
)


@kernel
def watch(
    people: Records,
    place: Place,
    robots: Records,
    force: Records,
    reactions: Records,
    key: np.uint64,
    periods: int,
    seen: Records,
    work: Workspace,
) -> None:
    """Let people walk and note the extremes of each."""
    for i in range(people.shape[0]):
        seen[i].robot_gap = seen[i].people_gap = seen[i].wall_gap = math.inf
        ends = place.routes[people[i].route, place.routes.shape[1] - 1, 2]
        seen[i].nominal_s = (ends - people[i].s) / max(people[i].desired_speed, 1e-9)
    for period in range(periods):
        social_step(
            people,
            place,
            robots[0],
            force[0],
            reactions,
            NO_HOOK,
            NO_STRETCH,
            np.uint64(key),
            period,
            DT_S,
            work,
        )
        is_over = True
        for i in range(people.shape[0]):
            is_over = is_over and people[i].status == GONE
        if is_over:
            break
        for _ in range(SUBSTEPS):
            for i in range(people.shape[0]):
                if people[i].status == PRESENT:
                    look(people, i, place.walls, robots, seen)
            move_people(people, DT_S / SUBSTEPS)
    for i in range(people.shape[0]):
        seen[i].arrived = 1 if seen[i].came and people[i].status == GONE else 0
        seen[i].last_mps = math.hypot(people[i].vx, people[i].vy)


@kernel
def look(people: Records, i: int, walls: Floats, robots: Records, seen: Records) -> None:
    """Note how person i stands and what it is about to do in the next physics step."""
    me, note = people[i], seen[i]
    dt_s = DT_S / SUBSTEPS
    note.came = 1
    note.walked_s += dt_s
    note.top = max(note.top, math.hypot(me.vx, me.vy) / me.desired_speed)
    gap = math.hypot(me.x - robots[0].x, me.y - robots[0].y) - me.radius - ROBOT_RADIUS_M
    note.robot_gap = min(note.robot_gap, gap)
    for j in range(people.shape[0]):
        if j != i and people[j].status == PRESENT:
            gap = math.hypot(me.x - people[j].x, me.y - people[j].y) - me.radius - people[j].radius
            note.people_gap = min(note.people_gap, gap)
    x, y = me.x + me.vx * dt_s, me.y + me.vy * dt_s
    for k in range(walls.shape[0]):
        x1, y1, x2, y2 = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
        wall_x, wall_y = nearest_on_segment(me.x, me.y, x1, y1, x2, y2)
        note.wall_gap = min(note.wall_gap, math.hypot(me.x - wall_x, me.y - wall_y) - me.radius)
        if segments_cross(me.x, me.y, x, y, x1, y1, x2, y2):
            note.tunnelled = 1


def robot_on_path(place: Place, share: float) -> Records:
    robots = records(ROBOT, 1)
    path = place.path.view(np.recarray)
    robots["s"] = share * path_length(path)
    robots["x"], robots["y"], robots["theta"], _ = path_pose(path, float(robots["s"][0]))
    return robots


@functools.cache
def walkers(place_name: str, share: float, periods: int = LONGEST) -> npt.NDArray[np.void]:
    """Return the observations of everybody who came by a standing robot."""
    config = make_config(place=place_name)
    source = ScenarioSampler(config)
    force = as_record(config.people.force)
    reactions = np.concatenate([as_record(reaction) for reaction in config.people.reactions])
    seen = []
    for key in range(EPISODES):
        scenario = source.draw(key)
        people, robots = scenario.people, robot_on_path(scenario.place, share)
        distance = np.hypot(people["x"] - robots["x"], people["y"] - robots["y"])
        people["status"][(people["status"] == PRESENT) & (distance < START_ROOM_M)] = GONE
        seen.append(np.zeros(len(people), WATCH))
        watch(
            people, scenario.place, robots, force, reactions, np.uint64(key), periods, seen[-1],
            make_workspace(len(people)),
        )  # fmt: skip
    together = np.concatenate(seen)
    return together[together["came"] == 1]


everywhere = pytest.mark.parametrize(("place", "share"), STANDS)


@everywhere
def test_at_least_995_of_1000_pass_a_standing_robot_without_contact(
    place: str, share: float
) -> None:
    gaps = walkers(place, share)["robot_gap"]
    assert len(gaps) >= (400 if place != "circle" else 250)
    assert np.mean(gaps > 0.0) >= 0.995


@everywhere
def test_at_least_95_of_100_reach_the_end_of_their_way(place: str, share: float) -> None:
    assert np.mean(walkers(place, share)["arrived"]) >= 0.95


@everywhere
def test_nobody_overlaps_anybody(place: str, share: float) -> None:
    assert walkers(place, share)["people_gap"].min() > -1e-6


@everywhere
def test_nobody_enters_or_crosses_a_wall(place: str, share: float) -> None:
    seen = walkers(place, share)
    assert not seen["tunnelled"].any()
    assert seen["wall_gap"].min() > -1e-6


@everywhere
def test_people_keep_to_their_own_pace(place: str, share: float) -> None:
    seen = walkers(place, share)
    limit = make_config().people.force.speed_limit_ratio
    assert seen["top"].max() <= limit + 1e-9
    arrived = seen[seen["arrived"] == 1]
    pace = arrived["nominal_s"] / arrived["walked_s"]
    assert 0.9 < np.median(pace) < 1.1


def test_in_a_doorway_that_the_robot_fills_people_wait_without_touching_it() -> None:
    seen = walkers("doorway", 0.5, 1200)
    assert len(seen) >= 400
    assert np.mean(seen["robot_gap"] > 0.0) >= 0.995
    assert seen["people_gap"].min() > -1e-6
    assert seen["wall_gap"].min() > -1e-6
    assert not seen["tunnelled"].any()
    waiting = seen[seen["arrived"] == 0]
    assert len(waiting) > 0.9 * len(seen)
    assert np.median(waiting["last_mps"]) < 0.5  # they shuffle about
