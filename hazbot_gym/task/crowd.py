"""People who are drawn: who they are and where they start, as a pure function of a key.

A scenario is drawn so that people are really met: a person is given a place on its route at the
moment when a robot at nominal speed would be there too, and starts as far back as its own speed
demands. What would start before the route begins enters later. Drawing is compiled and free of
rejection loops without bound: a start that is taken eight times sends the person to the beginning
of its route.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import People
from hazbot_gym.core.geometry import clip, path_length, path_pose, route_pose
from hazbot_gym.core.jit import kernel, scalar
from hazbot_gym.core.noise import SCENARIO, normal_pair, uniform4
from hazbot_gym.core.state import (
    ACROSS,
    AGAINST,
    ALONG,
    CONFRONTING,
    CROSSING,
    ENCOUNTERING,
    GONE,
    LEADING,
    PATTERN_NAMES,
    PERSON,
    PERSON_RADIUS_M,
    PRESENT,
    SCRIPTED,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Place,
    Record,
    Records,
    as_record,
    records,
)
from hazbot_gym.errors import InvalidInput

SPEED_LOW_MPS, SPEED_HIGH_MPS = 0.5, 2.2  # walking people (p5 to p95 of the real tracks, widened)
EARLIEST_MEETING_S = 3.0  # nobody is met before
HEAD_ON_SPREAD_M = 0.15  # lateral scatter of people who come straight at the robot
PASSING_OFFSET_M = 0.5  # least lateral offset of people who mean to pass
SIDESTEP_OFFSET_M = 0.8  # where a scripted head-on walker steps aside to
SIDESTEP_AHEAD_M = 1.5  # distance at which it has done so, if the robot drove at nominal speed
LEADER_GAP_M = (1.5, 5.0)  # initial distance of leaders
CROSSING_EARLY_S, CROSSING_LATE_S = (
    3.0,
    10.0,
)  # spread of crossings around the robot's own time there
START_ROOM_M = 1.0  # free distance to others at the start
ROBOT_ROOM_M = 1.4  # and to the robot
ATTEMPTS = 8


class Crowd(NamedTuple):
    """The ``people`` section of the config as numbers for kernels."""

    model: int
    family: int  # pattern of the first person, -1 for mixed
    fewest: int
    most: int
    mix_crossing: float  # cumulative shares of the patterns
    mix_encountering: float
    mix_leading: float
    share_attentive: float  # cumulative shares of the reactions
    share_inattentive: float
    share_wary: float
    mean_mps: float
    sd_mps: float
    leader_low_mps: float
    leader_high_mps: float
    nominal_speed_mps: float  # of the robot


class Sampler:
    """Draws the people of a scenario for one place."""

    def __init__(self, people: People, place: Place, nominal_speed_mps: float) -> None:
        """Prepare; raises InvalidInput if the place has no route for a pattern that is asked for."""
        has_crossing = bool(np.any(place.route_kinds == ACROSS))
        if people.family == "crossing" and not has_crossing:
            raise InvalidInput(
                "people.family: given 'crossing', but the place has no route across the path"
            )
        self._place = place
        self._slots = people.count[1]
        self._crowd = as_record(_crowd(people, has_crossing, nominal_speed_mps))

    def draw(self, key: int) -> Records:
        """Return (P,) PERSON records at time zero."""
        people = records(PERSON, self._slots)
        _draw_people(people, self._place, self._crowd, np.uint64(key))
        return people


def _crowd(people: People, has_crossing: bool, nominal_speed_mps: float) -> Crowd:
    mix = np.array(people.mix)
    if not has_crossing:
        mix[CROSSING] = 0.0
    if mix.sum() <= 0.0:
        raise InvalidInput("people.mix: asks for crossing only, but the place has no route across")
    mix = np.cumsum(mix / mix.sum())
    shares = np.cumsum(np.array(people.reaction_shares) / sum(people.reaction_shares))
    return Crowd(
        SCRIPTED if people.model == "scripted" else SOCIAL_FORCE,
        -1 if people.family == "mixed" else PATTERN_NAMES.index(people.family),
        *people.count,
        *(float(share) for share in mix[:3]),
        *(float(share) for share in shares[:3]),
        *people.speeds,
        nominal_speed_mps,
    )


# --- drawing -------------------------------------------------------------------------------------


@scalar
def _choose(u: float, first: float, second: float, third: float) -> int:
    """Return 0 to 3 for a uniform number and three cumulative shares."""
    if u < first:
        return 0
    if u < second:
        return 1
    return 2 if u < third else 3


@scalar
def _choose_route(kinds: Floats, kind: int, u: float) -> int:
    """Return a route of a kind, all equally likely; the first route if there is none."""
    count = 0
    for k in range(kinds.shape[0]):
        count += kinds[k] == kind
    wanted = min(int(u * count), count - 1)
    for k in range(kinds.shape[0]):
        if kinds[k] == kind:
            if wanted == 0:
                return k
            wanted -= 1
    return 0


@scalar
def _start_on_route(me: Record, place: Place, pattern: int, crowd: Crowd, u_when: float) -> float:
    """Return the arc length on its route at which a person would be at time zero (may be negative)."""
    on_path, on_route = place.route_anchors[me.route, 0], place.route_anchors[me.route, 1]
    if pattern == LEADING:
        gap = LEADER_GAP_M[0] + u_when * (LEADER_GAP_M[1] - LEADER_GAP_M[0])
        return float(on_route - on_path + gap)
    if pattern == CROSSING:
        spread = -CROSSING_EARLY_S + u_when * (CROSSING_EARLY_S + CROSSING_LATE_S)
        meets_s = max(on_path / crowd.nominal_speed_mps + spread, EARLIEST_MEETING_S)
        return float(on_route - me.desired_speed * meets_s)
    latest_s = max(path_length(place.path) / crowd.nominal_speed_mps - 1.0, EARLIEST_MEETING_S)
    meets_s = EARLIEST_MEETING_S + u_when * (latest_s - EARLIEST_MEETING_S)
    met_at = on_route + on_path - crowd.nominal_speed_mps * meets_s
    # Steps aside before the nominal robot is near, so that a slower or standing one is left alone too.
    me.sidestep_s = met_at - SIDESTEP_AHEAD_M * me.desired_speed / (
        me.desired_speed + crowd.nominal_speed_mps
    )
    return float(met_at - me.desired_speed * meets_s)


@scalar
def _lane(me: Record, pattern: int, room: float, u: float, is_scripted: bool) -> None:
    """Choose a person's lateral offset, and where it steps aside to."""
    side = 1.0 if u < 0.5 else -1.0
    spread = abs(2.0 * u - 1.0)  # uniform in [0, 1], whatever the side
    if pattern == ENCOUNTERING:
        low = min(PASSING_OFFSET_M + (0.1 if is_scripted else 0.0), room)
        me.offset = side * (low + spread * (room - low))
    elif pattern == CONFRONTING:
        me.offset = side * spread * min(HEAD_ON_SPREAD_M, room)
    else:
        me.offset = side * spread * min(0.4, room)
    me.sidestep_offset = me.offset
    if pattern == CONFRONTING and is_scripted:
        me.sidestep_offset = side * min(SIDESTEP_OFFSET_M, room)


@scalar
def _place_at(me: Record, place: Place, s: float) -> None:
    """Put a person on its lane at arc length s of its route, walking; before it begins, waiting."""
    me.status = PRESENT if s >= 0.0 else WAITING
    me.enters_s = max(-s / me.desired_speed, 0.0)
    me.s = max(s, 0.0)
    x, y, tx, ty = route_pose(place.routes, me.route, me.s)
    me.x, me.y = x - me.offset * ty, y + me.offset * tx
    me.vx, me.vy = me.desired_speed * tx, me.desired_speed * ty


@scalar
def _has_room(people: Records, i: int, place: Place) -> bool:
    """Tell whether person i starts clear of the robot and of those drawn before."""
    me = people[i]
    x, y, _, _ = path_pose(place.path, 0.0)
    if me.status == PRESENT and math.hypot(me.x - x, me.y - y) < ROBOT_ROOM_M:
        return False
    for j in range(i):
        other = people[j]
        if me.status == PRESENT and other.status == PRESENT:
            if math.hypot(me.x - other.x, me.y - other.y) < START_ROOM_M:
                return False
    return True


@scalar
def _draw_person(
    people: Records, i: int, place: Place, crowd: Crowd, key: np.uint64, attempt: int
) -> None:
    """Draw everything about person i but whether there is room."""
    me = people[i]
    u_pattern, u_route, u_when, u_lane = uniform4(key, SCENARIO, attempt, 2 * i)
    u_reaction, u_speed, u_speed_2, _ = uniform4(key, SCENARIO, attempt, 2 * i + 1)
    pattern = _choose(u_pattern, crowd.mix_crossing, crowd.mix_encountering, crowd.mix_leading)
    if i == 0 and crowd.family >= 0:
        pattern = crowd.family
    kind = ACROSS if pattern == CROSSING else ALONG if pattern == LEADING else AGAINST
    me.route = _choose_route(place.route_kinds, kind, u_route)
    speed = crowd.mean_mps + crowd.sd_mps * normal_pair(u_speed, u_speed_2)[0]
    me.desired_speed = clip(speed, SPEED_LOW_MPS, SPEED_HIGH_MPS)
    if pattern == LEADING:
        me.desired_speed = crowd.leader_low_mps + u_speed * (
            crowd.leader_high_mps - crowd.leader_low_mps
        )
    me.model, me.radius = crowd.model, PERSON_RADIUS_M
    me.reaction = _choose(
        u_reaction, crowd.share_attentive, crowd.share_inattentive, crowd.share_wary
    )
    _lane(me, pattern, place.route_rooms[me.route], u_lane, crowd.model == SCRIPTED)
    _place_at(me, place, _start_on_route(me, place, pattern, crowd, u_when))


@kernel
def _draw_people(people: Records, place: Place, crowds: Records, key: np.uint64) -> None:
    crowd = crowds[0]
    u, _, _, _ = uniform4(key, SCENARIO, 0, 1 << 20)
    count = min(crowd.fewest + int(u * (crowd.most - crowd.fewest + 1)), crowd.most)
    for i in range(people.shape[0]):
        if i >= count:
            people[i].status = GONE  # before it came
            continue
        for attempt in range(ATTEMPTS):
            _draw_person(people, i, place, crowd, key, attempt)
            if _has_room(people, i, place):
                break
        else:
            _place_at(people[i], place, -1e-6)
