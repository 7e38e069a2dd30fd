"""Sensor models: a ring of ultrasonic range sensors, and a people tracker.

All noise is a pure function of (key, stream, decision, index), so that it does not depend on the
policy's actions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config, Tracker
from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.geometry import is_in_sight, may_be_near, norm
from hazbot_gym.core.jit import lean_kernel, routine, scalar
from hazbot_gym.core.noise import SONAR, TRACKER, noise_value, uniform4
from hazbot_gym.core.patterns import Thresholds, classify
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.core.sensor_ring import SensorRecord, ring_table, sensors_of
from hazbot_gym.core.state import (
    BESIDE,
    NO_PATTERN,
    PRESENT,
    TRACK,
    Floats,
    Records,
    RobotRecord,
    TrackRecord,
    records,
)
from hazbot_gym.core.ultrasonic import (
    Cone,
    Ultrasonic,
    disc_echo,
    may_meet_disc,
    may_meet_segment,
    segment_echo,
    turned,
)


class TrackerParameters(NamedTuple):
    """The config's ``Tracker`` as numbers for kernels, with parameters of the labels."""

    range_m: float
    position_noise_m: float
    velocity_noise_mps: float
    dropout: float
    is_privileged: bool  # report the true state of all present people
    intended_speed_mps: float  # heading speed assumed for the labels of a stopped robot


class SensorParameters(NamedTuple):
    """Parameters of ``perceive``; ``as_record`` converts it for kernels."""

    ultrasonic: Ultrasonic
    tracker: TrackerParameters
    patterns: Thresholds


def tracker_of(config: Config) -> Tracker:
    """Return the people tracker of the config's tier; the privileged tracker has no errors."""
    tracker = config.sensors.tracker
    if config.tier != "privileged":
        return tracker
    return tracker._replace(
        position_noise_m=0.0, velocity_noise_mps=0.0, dropout=0.0, latency_steps=0
    )


def sensor_parameters(config: Config) -> SensorParameters:
    """Return the sensors' parameters for a config."""
    tracker = tracker_of(config)
    return SensorParameters(
        config.sensors.ultrasonic,
        TrackerParameters(
            range_m=tracker.range_m,
            position_noise_m=tracker.position_noise_m,
            velocity_noise_mps=tracker.velocity_noise_mps,
            dropout=tracker.dropout,
            is_privileged=config.tier == "privileged",
            intended_speed_mps=config.drive.nominal_speed_mps,
        ),
        Thresholds(moving_mps=tracker.moving_mps),
    )


def ring_of(config: Config) -> Records:
    """Return the ring of range sensors (N,) of a config, as RING records."""
    sensors = config.sensors
    return ring_table(sensors_of(sensors.ring), sensors.ultrasonic.half_cone_rad)


@scalar
def echo(cone: Cone, robot: RobotRecord, people: Records, walls: Floats, p: Ultrasonic) -> float:
    """Return the true distance of a sensor's first echo, at most its range [m]."""
    cos_miss = sin_cos(p.miss_angle_rad)[1] if p.miss_angle_rad < math.pi / 2 else 0.0
    x = robot.x + p.mount_radius_m * cone.axis_x
    y = robot.y + p.mount_radius_m * cone.axis_y
    nearest = p.range_m
    for i in range(people.shape[0]):
        me = people[i]
        dx, dy, reach = me.x - x, me.y - y, nearest + me.radius
        is_in_range = me.status == PRESENT and dx * dx + dy * dy < reach * reach
        if is_in_range and may_meet_disc(dx, dy, me.radius, cone):
            nearest = min(nearest, disc_echo(dx, dy, me.radius, cone))
    for k in range(walls.shape[0]):
        x1, y1, x2, y2 = walls[k, 0] - x, walls[k, 1] - y, walls[k, 2] - x, walls[k, 3] - y
        is_in_range = may_be_near(0.0, 0.0, x1, y1, x2, y2, nearest)
        if is_in_range and may_meet_segment(x1, y1, x2, y2, cone):
            nearest = min(nearest, segment_echo(x1, y1, x2, y2, cone, cos_miss))
    return nearest


@routine
def sense_ranges(
    robot: RobotRecord, people: Records, walls: Floats, p: Ultrasonic, ring: Records,
    key: np.uint64, step: int, ranges: Floats,
) -> None:  # fmt: skip
    """Write the readings [m]; with sequential firing, one reading is updated per decision."""
    sin_t, cos_t = sin_cos(robot.theta)
    u1 = u2 = u3 = (0.0, 0.0, 0.0, 0.0)
    for i in range(ring.shape[0]):
        if i % 4 == 0:  # random numbers come in fours
            u1 = uniform4(key, SONAR, step, 3 * (i // 4))
            u2 = uniform4(key, SONAR, step, 3 * (i // 4) + 1) if p.gaussian else u1
            u3 = uniform4(key, SONAR, step, 3 * (i // 4) + 2) if p.cross_talk > 0.0 else u1
        if p.sequential and step > 0 and step % ring.shape[0] != i:
            continue
        reading = echo(_cone(ring[i], sin_t, cos_t), robot, people, walls, p)
        if p.cross_talk > 0.0 and u3[i % 4] < p.cross_talk:
            cone = _cone(ring[ring[i].mirror], sin_t, cos_t)
            reading = min(reading, echo(cone, robot, people, walls, p))
        if reading < p.range_m:  # no noise without an echo
            reading += noise_value(u1[i % 4], u2[i % 4], p.noise_m, p.gaussian)
        ranges[i] = min(max(reading, 0.0), p.range_m)


@scalar
def _cone(sensor: SensorRecord, sin_t: float, cos_t: float) -> Cone:
    """Return the cone of a sensor at the heading t."""
    cone = Cone(sensor.axis_x, sensor.axis_y, sensor.cos_half, sensor.sin_half)
    return turned(cone, sin_t, cos_t)


@scalar
def nearest_ahead(ranges: Floats, ring: Records) -> float:
    """Return the smallest reading of the sensors that point ahead [m], or inf."""
    nearest = math.inf
    for i in range(ring.shape[0]):
        if ring[i].is_ahead == 1:
            nearest = min(nearest, ranges[i])
    return nearest


@scalar
def remember(people: Records, history: Records, step: int) -> None:
    """Write the true state of the people into this decision's row of the history."""
    row = step % history.shape[0]
    for i in range(people.shape[0]):
        seen = history[row, i]
        seen.visible = 1 if people[i].status == PRESENT else 0
        seen.x, seen.y = people[i].x, people[i].y
        seen.vx, seen.vy = people[i].vx, people[i].vy


@scalar
def _is_seen(
    seen: TrackRecord,
    distance: float,
    robot: RobotRecord,
    walls: Floats,
    t: TrackerParameters,
    u: float,
) -> bool:
    """Return True if the tracker reports a person: in range, in line of sight, and not missed."""
    if seen.visible == 0 or t.is_privileged:
        return bool(seen.visible == 1)
    if distance > t.range_m or u < t.dropout:
        return False
    return is_in_sight(robot.x, robot.y, seen.x, seen.y, walls)


@routine
def track_people(
    robot: RobotRecord, walls: Floats, history: Records, p: SensorParameters, key: np.uint64,
    step: int, tracks: Records,
) -> None:  # fmt: skip
    """Write the tracker's report, from the oldest row of the history (its latency).

    A person is reported within range and in line of sight, both from the robot's current pose. The
    pattern label is assigned within 3.6 m (Hall's social distance, as in the track counts) and kept
    while the person stays within: it describes the encounter, not the current geometry.
    """
    t = p.tracker
    row = (step + 1) % history.shape[0] if step + 1 >= history.shape[0] else 0
    for i in range(tracks.shape[0]):
        seen, track = history[row, i], tracks[i]
        dropped = uniform4(key, TRACKER, step, 2 * i + 1)[0] if t.dropout > 0.0 else 1.0
        distance = norm(seen.x - robot.x, seen.y - robot.y)
        is_seen = _is_seen(seen, distance, robot, walls, t, dropped)
        track.visible = 1 if is_seen else 0
        if seen.visible == 0 or distance > SOCIAL_M:
            track.pattern = NO_PATTERN
        if not is_seen:
            continue
        u1, u2, u3, u4 = uniform4(key, TRACKER, step, 2 * i)
        track.x = seen.x + (2.0 * u1 - 1.0) * t.position_noise_m
        track.y = seen.y + (2.0 * u2 - 1.0) * t.position_noise_m
        track.vx = seen.vx + (2.0 * u3 - 1.0) * t.velocity_noise_mps
        track.vy = seen.vy + (2.0 * u4 - 1.0) * t.velocity_noise_mps
        is_open = track.pattern == NO_PATTERN or track.pattern == BESIDE
        if is_open and distance <= SOCIAL_M:
            track.pattern = classify(
                track.x - robot.x,
                track.y - robot.y,
                robot.theta,
                t.intended_speed_mps,
                track.vx,
                track.vy,
                p.patterns,
            )


@scalar
def perceive(
    robot: RobotRecord, people: Records, walls: Floats, p: SensorParameters, ring: Records,
    history: Records, key: np.uint64, step: int, ranges: Floats, tracks: Records,
) -> None:  # fmt: skip
    """Update all sensors at a decision.

    Args:
        robot: The robot's record.
        people: (P,) PERSON records.
        walls: (W, 4) segments [m].
        p: Parameters of the sensors.
        ring: (N,) RING records.
        history: (latency + 1, P) TRACK records, updated in place.
        key: Key of the scenario's noise.
        step: Number of the decision since the reset.
        ranges: (N,) readings [m], output.
        tracks: (P,) TRACK records, output.
    """
    sense_ranges(robot, people, walls, p.ultrasonic, ring, key, step, ranges)
    remember(people, history, step)
    track_people(robot, walls, history, p, key, step, tracks)


@lean_kernel
def perceive_kernel(
    robots: Records, people: Records, walls: Floats, parameters: Records, ring: Records,
    history: Records, key: np.uint64, step: int, ranges: Floats, tracks: Records,
) -> None:  # fmt: skip
    """Entry point from Python: ``perceive`` for arrays of one record."""
    perceive(
        robots[0], people, walls, parameters[0], ring, history, np.uint64(key), step, ranges, tracks
    )


def blank_tracks(people: int) -> Records:
    """Return tracks without any visible person."""
    tracks = records(TRACK, people)
    tracks["pattern"] = NO_PATTERN
    return tracks
