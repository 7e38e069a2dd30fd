"""Random people of a scenario, as a pure function of a key.

Scenarios are drawn such that people meet the robot. A person reaches the meeting point on its route
at the same time as a robot at nominal speed would, and starts as far back as the person's speed
requires. If the start would lie before the beginning of the route, the person enters later. Drawing
is compiled and has no unbounded rejection loop: after eight occupied starts the person queues at
the beginning of its route.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.config import People, Speeds
from hazbot_gym.core.geometry import clip, norm, path_length, path_pose, route_pose
from hazbot_gym.core.jit import scalar
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
    OWN,
    PATTERN_NAMES,
    PERSON_RADIUS_M,
    PRESENT,
    SCRIPTED,
    SOCIAL_FORCE,
    WAITING,
    Floats,
    Ints,
    PersonRecord,
    Place,
    Records,
)
from hazbot_gym.errors import InvalidInput

SPEED_LOW_MPS, SPEED_HIGH_MPS = 0.5, 2.2  # walking people (p5 to p95 of the real tracks, widened)
EARLIEST_MEETING_S = 3.0  # earliest meeting
HEAD_ON_SPREAD_M = 0.15  # lateral scatter of head-on people
PASSING_OFFSET_M = 0.65  # least lateral offset of passing people, beyond head-on (0.6 m)
SIDESTEP_OFFSET_M = 0.8  # lateral offset of a scripted head-on walker after stepping aside
SIDESTEP_AHEAD_M = 0.5  # distance at which this is complete, for a robot at nominal speed
LEADER_GAP_M = (1.5, 5.0)  # initial distance of leaders
START_ROOM_M = 1.0  # free distance to others at the start
ROBOT_ROOM_M = 1.4  # and to the robot
ATTEMPTS = 8
MODELS = {"scripted": SCRIPTED, "social_force": SOCIAL_FORCE}  # those of the library


class Crowd(NamedTuple):
    """The ``people`` section of the config as numbers for kernels."""

    model: int = SOCIAL_FORCE
    family: int = -1  # pattern of the first person, -1 for mixed
    fewest: int = 0
    most: int = 0
    mix_crossing: float = 0.25  # cumulative shares of the patterns
    mix_encountering: float = 0.5
    mix_leading: float = 0.75
    crossing_early_s: float = -3.0  # first crossing, relative to a nominal robot's arrival
    crossing_late_s: float = 4.0  # last one
    speeds: Speeds = Speeds()
    nominal_speed_mps: float = 0.5  # of the robot


def crowd_of(people: People, place: Place, nominal_speed_mps: float) -> Crowd:
    """Return the distribution of people at a place.

    Raises:
        InvalidInput: The place has no route for the requested pattern.
    """
    mix = np.array(people.mix)
    if not np.any(place.route_kinds == ACROSS):
        mix[CROSSING] = 0.0
        if people.family == "crossing":
            raise InvalidInput(
                "people.family: given 'crossing', but the place has no route across the path"
            )
    if mix.sum() <= 0.0:
        raise InvalidInput("people.mix: asks for crossing only, but the place has no route across")
    mix = np.cumsum(mix / mix.sum())
    return Crowd(
        model=MODELS.get(people.model, OWN),
        family=-1 if people.family == "mixed" else PATTERN_NAMES.index(people.family),
        fewest=people.count[0],
        most=people.count[1],
        mix_crossing=float(mix[CROSSING]),
        mix_encountering=float(mix[ENCOUNTERING]),
        mix_leading=float(mix[LEADING]),
        crossing_early_s=people.crossing_window_s[0],
        crossing_late_s=people.crossing_window_s[1],
        speeds=people.speeds,
        nominal_speed_mps=nominal_speed_mps,
    )


# --- drawing -------------------------------------------------------------------------------------


@scalar
def _choose_pattern(u: float, crowd: Crowd) -> int:
    """Return the pattern for a uniform number."""
    if u < crowd.mix_crossing:
        return CROSSING
    if u < crowd.mix_encountering:
        return ENCOUNTERING
    return LEADING if u < crowd.mix_leading else CONFRONTING


@scalar
def choose_reaction(u: float, shares: Floats) -> int:
    """Return the reaction for a uniform number and the cumulative shares (4,)."""
    for reaction in range(shares.shape[0] - 1):
        if u < shares[reaction]:
            return reaction
    return int(shares.shape[0]) - 1


@scalar
def _choose_route(kinds: Ints, kind: int, u: float) -> int:
    """Return a random route of a kind, uniformly."""
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
def _start_on_route(
    me: PersonRecord, place: Place, pattern: int, crowd: Crowd, u_when: float
) -> float:
    """Return a person's arc length on its route at time zero (may be negative)."""
    on_path, on_route = place.route_anchors[me.route, 0], place.route_anchors[me.route, 1]
    if pattern == LEADING:
        gap = LEADER_GAP_M[0] + u_when * (LEADER_GAP_M[1] - LEADER_GAP_M[0])
        return float(on_route - on_path + gap)
    if pattern == CROSSING:
        early_s, late_s = crowd.crossing_early_s, crowd.crossing_late_s
        after_s = early_s + u_when * (late_s - early_s)
        meets_s = max(on_path / crowd.nominal_speed_mps + after_s, EARLIEST_MEETING_S)
        return float(on_route - me.desired_speed * meets_s)
    latest_s = max(path_length(place.path) / crowd.nominal_speed_mps - 1.0, EARLIEST_MEETING_S)
    meets_s = EARLIEST_MEETING_S + u_when * (latest_s - EARLIEST_MEETING_S)
    met_at = on_route + on_path - crowd.nominal_speed_mps * meets_s
    # Steps aside before a robot at nominal speed is near, and so before any slower one.
    me.sidestep_s = met_at - SIDESTEP_AHEAD_M * me.desired_speed / (
        me.desired_speed + crowd.nominal_speed_mps
    )
    return float(met_at - me.desired_speed * meets_s)


@scalar
def _lane(me: PersonRecord, pattern: int, room: float, u: float, is_scripted: bool) -> None:
    """Choose a person's lateral offsets, before and after stepping aside."""
    side = 1.0 if u < 0.5 else -1.0
    spread = abs(2.0 * u - 1.0)  # uniform in [0, 1], for either side
    if pattern == ENCOUNTERING:
        low = min(PASSING_OFFSET_M, room)
        me.offset = side * (low + spread * (room - low))
    elif pattern == CONFRONTING:
        me.offset = side * spread * min(HEAD_ON_SPREAD_M, room)
    else:
        me.offset = side * spread * min(0.4, room)
    me.sidestep_offset = me.offset
    if pattern == CONFRONTING and is_scripted:
        me.sidestep_offset = side * min(SIDESTEP_OFFSET_M, room)


@scalar
def _place_at(me: PersonRecord, place: Place, s: float) -> None:
    """Place a person on its lane at arc length s of its route; a negative s means waiting."""
    me.status = PRESENT if s >= 0.0 else WAITING
    me.enters_s = max(-s / me.desired_speed, 0.0)
    me.s = max(s, 0.0)
    x, y, tx, ty = route_pose(place.routes, me.route, me.s)
    me.x, me.y = x - me.offset * ty, y + me.offset * tx
    me.vx, me.vy = me.desired_speed * tx, me.desired_speed * ty


@scalar
def _has_room(people: Records, i: int, place: Place, nominal_speed_mps: float) -> bool:
    """Return True if person i starts clear of a nominal robot and of earlier people."""
    me = people[i]
    x, y, _, _ = path_pose(place.path, nominal_speed_mps * me.enters_s)
    if norm(me.x - x, me.y - y) < ROBOT_ROOM_M:
        return False
    for j in range(i):
        other = people[j]
        both = me.status == PRESENT and other.status == PRESENT
        if both and norm(me.x - other.x, me.y - other.y) < START_ROOM_M:
            return False
    return True


@scalar
def _draw_speed(speeds: Speeds, is_leader: bool, u1: float, u2: float) -> float:
    """Return a walking speed: cut normal, or uniform for leaders."""
    if is_leader:
        return speeds.leader_low_mps + u1 * (speeds.leader_high_mps - speeds.leader_low_mps)
    speed = speeds.mean_mps + speeds.sd_mps * normal_pair(u1, u2)[0]
    return clip(speed, SPEED_LOW_MPS, SPEED_HIGH_MPS)


@scalar
def _draw_person(
    people: Records, i: int, place: Place, crowd: Crowd, shares: Floats, key: np.uint64,
    attempt: int,
) -> None:  # fmt: skip
    """Draw person i, without checking for room."""
    me = people[i]
    u_pattern, u_route, u_when, u_lane = uniform4(key, SCENARIO, attempt, 2 * i)
    u_reaction, u_speed, u_speed_2, _ = uniform4(key, SCENARIO, attempt, 2 * i + 1)
    pattern = _choose_pattern(u_pattern, crowd)
    if i == 0 and crowd.family >= 0:
        pattern = crowd.family
    kind = ACROSS if pattern == CROSSING else ALONG if pattern == LEADING else AGAINST
    me.route = _choose_route(place.route_kinds, kind, u_route)
    me.desired_speed = _draw_speed(crowd.speeds, pattern == LEADING, u_speed, u_speed_2)
    me.model, me.radius = crowd.model, PERSON_RADIUS_M
    me.reaction = choose_reaction(u_reaction, shares)
    _lane(me, pattern, place.route_rooms[me.route], u_lane, crowd.model == SCRIPTED)
    _place_at(me, place, _start_on_route(me, place, pattern, crowd, u_when))


@scalar
def draw_people(
    people: Records, place: Place, crowd: Crowd, shares: Floats, key: np.uint64
) -> None:
    """Draw a crowd.

    Args:
        people: (P,) zeroed PERSON records, output.
        place: Path and routes.
        crowd: Distribution of people.
        shares: (4,) cumulative shares of the reactions.
        key: Key of the scenario.
    """
    u, _, _, _ = uniform4(key, SCENARIO, 0, 1 << 20)
    count = min(crowd.fewest + int(u * (crowd.most - crowd.fewest + 1)), crowd.most)
    for i in range(people.shape[0]):
        if i >= count:
            people[i].status = GONE  # before its entry
            continue
        for attempt in range(ATTEMPTS):
            _draw_person(people, i, place, crowd, shares, key, attempt)
            if _has_room(people, i, place, crowd.nominal_speed_mps):
                break
        else:
            _place_at(people[i], place, -START_ROOM_M * (i + 1))
