from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
import pymunk
import pytest

import hazbot_gym  # noqa: F401 - registers the environments
from hazbot_gym.core.patterns import Thresholds
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.core.sensor_ring import PAPER, SIX, RangeSensor, Sensors, ring_table
from hazbot_gym.core.state import (
    BESIDE,
    CONFRONTING,
    CROSSING,
    ENCOUNTERING,
    GONE,
    LEADING,
    NO_PATTERN,
    PERSON,
    PRESENT,
    ROBOT,
    TRACK,
    Floats,
    Records,
    as_record,
    records,
)
from hazbot_gym.core.ultrasonic import Ultrasonic, cone_at, disc_echo
from hazbot_gym.sim.perception import (
    SensorParameters,
    TrackerParameters,
    blank_tracks,
    echo,
    perceive_kernel,
    remember,
    sense_ranges,
    track_people,
)

FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, DIAGONAL_LEFT, DIAGONAL_RIGHT = range(len(SIX))
QUIET_SONAR = Ultrasonic(noise_m=0.0)
TRACKER = TrackerParameters(
    range_m=8.0,
    position_noise_m=0.0,
    velocity_noise_mps=0.0,
    dropout=0.0,
    is_privileged=False,
    intended_speed_mps=0.5,
)
OPEN = np.zeros((0, 4))
KEY = 42


class Rig:
    """A robot at the origin that looks along x, with people around it and its sensors."""

    def __init__(
        self,
        *positions: tuple[float, float],
        walls: Floats = OPEN,
        sonar: Ultrasonic = QUIET_SONAR,
        sensors: Sensors = PAPER,
        latency_steps: int = 0,
        key: int = KEY,
        **tracker: Any,
    ) -> None:
        self.robots = records(ROBOT, 1)
        self.people = records(PERSON, len(positions))
        self.people["status"], self.people["radius"] = PRESENT, 0.2
        self.people["vx"] = -1.0
        if positions:
            self.people["x"], self.people["y"] = np.transpose(positions)
        self.walls, self.key, self.step = walls, np.uint64(key), 0
        parameters = SensorParameters(sonar, TRACKER._replace(**tracker), Thresholds())
        self.parameters = as_record(parameters)
        self.history = records(TRACK, (latency_steps + 1) * len(positions))
        self.history = self.history.reshape(latency_steps + 1, len(positions))
        self.ring = ring_table(sensors, sonar.half_cone_rad)
        self.ranges, self.tracks = np.zeros(len(sensors)), blank_tracks(len(positions))

    def look(self) -> Records:
        """Let the sensors report a decision; return the tracks."""
        perceive_kernel(
            self.robots, self.people, self.walls, self.parameters, self.ring, self.history,
            self.key, self.step, self.ranges, self.tracks,
        )  # fmt: skip
        self.step += 1
        return self.tracks

    def labels_at(self, *xs: float) -> list[int]:
        """Put the only person at each x in turn; return the label it then has."""
        labels = []
        for x in xs:
            self.people["x"] = x
            labels.append(int(self.look()["pattern"][0]))
        return labels


# --- who is tracked ------------------------------------------------------------------------------


def test_people_are_tracked_within_range() -> None:
    tracks = Rig((7.99, 0.0), (8.01, 0.0), (0.0, -3.0), (-5.0, 0.0)).look()
    assert tracks["visible"].tolist() == [1, 0, 1, 1]


def test_without_noise_the_track_is_the_person() -> None:
    tracks = Rig((2.0, 1.0)).look()
    assert tracks[["x", "y", "vx", "vy"]].tolist() == [(2.0, 1.0, -1.0, 0.0)]


def test_nobody_is_seen_through_a_wall_or_round_a_corner() -> None:
    corner = np.array([[2.0, -5.0, 2.0, 1.0], [2.0, 1.0, 5.0, 1.0]])
    tracks = Rig((3.0, 0.0), (3.0, 1.2), (3.0, 2.0), (1.9, 0.9), walls=corner).look()
    assert tracks["visible"].tolist() == [0, 0, 1, 1]


def test_people_who_are_not_there_are_not_seen() -> None:
    rig = Rig((2.0, 0.0))
    rig.people["status"] = GONE
    assert rig.look()["visible"].tolist() == [0]


def test_the_privileged_tracker_sees_everybody_everywhere() -> None:
    wall = np.array([[1.0, -5.0, 1.0, 5.0]])
    rig = Rig((2.0, 0.0), (30.0, 0.0), (3.0, 0.0), walls=wall, is_privileged=True, dropout=1.0)
    rig.people["status"][2] = GONE
    assert rig.look()["visible"].tolist() == [1, 1, 0]


# --- noise ---------------------------------------------------------------------------------------


def test_tracks_err_within_the_noise_and_use_all_of_it() -> None:
    rig = Rig((3.0, 1.0), position_noise_m=0.03, velocity_noise_mps=0.05)
    errors = []
    for _ in range(400):
        track = rig.look()[0]
        errors.append((track["x"] - 3.0, track["y"] - 1.0, track["vx"] + 1.0, track["vy"]))
    widths = np.array([0.03, 0.03, 0.05, 0.05])
    assert np.all(np.abs(errors) <= widths)
    assert np.all(np.abs(errors).max(axis=0) > 0.95 * widths)
    assert np.abs(np.mean(errors, axis=0) / widths).max() < 0.15
    assert np.abs(np.corrcoef(np.transpose(errors)) - np.eye(4)).max() < 0.2


def test_people_are_missed_at_the_dropout_rate() -> None:
    rig = Rig((3.0, 1.0), (3.0, -1.0), dropout=0.2)
    seen = np.array([rig.look()["visible"].copy() for _ in range(2000)])
    assert seen.mean(axis=0) == pytest.approx(0.8, abs=0.03)
    assert abs(np.corrcoef(seen.T)[0, 1]) < 0.1


def test_noise_is_the_same_for_the_same_key_wherever_the_robot_is() -> None:
    def errors(key: int, x: float) -> Floats:
        rig = Rig((3.0, 1.0), position_noise_m=0.03, key=key)
        rig.robots["x"] = x
        return np.array([rig.look()["x"][0] for _ in range(20)])

    assert errors(1, 0.0).tolist() == errors(1, 1.0).tolist()
    assert errors(1, 0.0).tolist() != errors(2, 0.0).tolist()


@pytest.mark.parametrize("latency", [1, 3])
def test_the_tracker_reports_what_was_the_case_some_decisions_ago(latency: int) -> None:
    rig = Rig((2.0, 0.0), latency_steps=latency)
    reported = []
    for step in range(10):
        rig.people["x"] = 2.0 + 0.1 * step
        reported.append(float(rig.look()["x"][0]))
    late = [2.0 + 0.1 * max(step - latency, 0) for step in range(10)]
    assert reported == pytest.approx(late)


def test_who_leaves_is_seen_as_long_as_the_latency_lasts() -> None:
    rig = Rig((2.0, 0.0), latency_steps=2)
    seen = []
    for step in range(6):
        rig.people["status"] = PRESENT if step < 3 else GONE
        seen.append(int(rig.look()["visible"][0]))
    assert seen == [1, 1, 1, 1, 1, 0]


# --- labels --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("x", "y", "vx", "vy", "label"),
    [
        (3.0, 0.0, -1.0, 0.0, CONFRONTING),
        (3.0, 0.9, -1.0, 0.0, ENCOUNTERING),
        (2.0, 2.0, 0.0, -1.0, CROSSING),
        (3.0, 0.0, 0.4, 0.0, LEADING),
        (1.0, 1.2, 0.4, 0.0, BESIDE),
        (-2.0, 0.0, 1.0, 0.0, NO_PATTERN),
    ],
)
def test_a_stopped_robot_labels_people_by_where_it_means_to_go(
    x: float, y: float, vx: float, vy: float, label: int
) -> None:
    rig = Rig((x, y))
    rig.people["vx"], rig.people["vy"] = vx, vy
    assert rig.look()["pattern"].tolist() == [label]


def test_labels_are_given_within_the_social_distance() -> None:
    assert Rig((0.0, 0.0)).labels_at(SOCIAL_M + 0.05, SOCIAL_M - 0.05) == [NO_PATTERN, CONFRONTING]


def test_a_label_says_how_two_met_until_they_are_far_apart() -> None:
    """Somebody who came head-on is behind the robot now, where nobody would be given a label."""
    labels = Rig((0.0, 0.0)).labels_at(3.0, 1.0, -1.0, -3.5, -3.7, -3.5)
    assert labels == [CONFRONTING] * 4 + [NO_PATTERN] * 2


def test_a_label_outlives_being_missed() -> None:
    rig = Rig((3.0, 0.0))
    rig.look()
    rig.walls = np.array([[1.0, -1.0, 1.0, 1.0]])
    assert rig.look()[["visible", "pattern"]].tolist() == [(0, CONFRONTING)]
    rig.people["status"] = GONE
    assert rig.look()[["visible", "pattern"]].tolist() == [(0, NO_PATTERN)]


def test_who_walks_beside_gets_a_label_when_that_changes() -> None:
    rig = Rig((1.0, 1.2))
    rig.people["vx"] = 0.4
    assert rig.look()["pattern"].tolist() == [BESIDE]
    rig.people["x"] = 3.0
    assert rig.look()["pattern"].tolist() == [LEADING]


# --- ultrasonic ----------------------------------------------------------------------------------


def test_an_open_place_answers_with_silence_and_without_noise() -> None:
    rig = Rig(sonar=Ultrasonic(noise_m=0.5))
    rig.look()
    assert rig.ranges.tolist() == [4.0] * 4


def test_somebody_on_the_axis_of_a_sensor_is_heard_at_the_distance_of_the_surfaces() -> None:
    axis = math.radians(15.0)
    rig = Rig((2.0 * math.cos(axis), 2.0 * math.sin(axis)))
    rig.look()
    assert rig.ranges[FRONT_LEFT] == pytest.approx(2.0 - 0.2 - QUIET_SONAR.mount_radius_m)
    assert rig.ranges[[FRONT_RIGHT, LEFT]].tolist() == [4.0, 4.0]


def test_people_ahead_are_heard_by_both_front_sensors() -> None:
    rig = Rig((2.0, 0.0))
    rig.look()
    assert rig.ranges[FRONT_LEFT] == pytest.approx(rig.ranges[FRONT_RIGHT])
    assert 1.5 < rig.ranges[FRONT_LEFT] < 1.6


def test_two_more_sensors_hear_somebody_who_stands_in_the_blind_sector() -> None:
    bearing, away_m = math.radians(50.0), 1.2
    person = away_m * math.cos(bearing), away_m * math.sin(bearing)
    four, six = Rig(person), Rig(person, sensors=SIX)
    four.look()
    six.look()

    assert four.ranges.tolist() == [4.0] * 4
    assert six.ranges.tolist()[:4] == [4.0] * 4
    axis, mount = math.radians(52.5), QUIET_SONAR.mount_radius_m
    dx, dy = person[0] - mount * math.cos(axis), person[1] - mount * math.sin(axis)
    assert six.ranges[DIAGONAL_LEFT] == pytest.approx(math.hypot(dx, dy) - 0.2)
    assert six.ranges[DIAGONAL_RIGHT] == 4.0


def test_a_sensor_of_ones_own_has_its_direction_and_its_cone() -> None:
    behind = RangeSensor("behind", math.pi), RangeSensor("wide", 0.0, half_cone_rad=0.9)
    rig = Rig((-2.0, 0.0), (1.0, 0.8), sensors=behind)
    rig.look()

    mount = QUIET_SONAR.mount_radius_m
    assert rig.ranges[0] == pytest.approx(2.0 - mount - 0.2)
    assert rig.ranges[1] == pytest.approx(disc_echo(1.0 - mount, 0.8, 0.2, cone_at(0.0, 0.9)))
    assert rig.ranges[1] == pytest.approx(math.hypot(1.0 - mount, 0.8) - 0.2)


def test_the_first_four_sensors_have_the_same_noise_in_every_ring() -> None:
    walls = np.array([[-9.0, 1.0, 9.0, 1.0], [-9.0, -1.0, 9.0, -1.0]])
    four, six = (Rig(walls=walls, sonar=Ultrasonic(), sensors=s) for s in (PAPER, SIX))
    readings = []
    for _ in range(100):
        four.look()
        six.look()
        assert four.ranges.tolist() == six.ranges[:4].tolist()
        readings.append(six.ranges.copy())
    noise = np.transpose(readings) - np.mean(readings, axis=0)[:, None]
    off_diagonal = np.corrcoef(noise) - np.eye(len(SIX))
    assert np.abs(off_diagonal).max() < 0.4  # independent of each other


def test_ranges_err_within_the_noise() -> None:
    rig = Rig(walls=np.array([[-9.0, 1.0, 9.0, 1.0]]), sonar=Ultrasonic(noise_m=0.03))
    readings = []
    for _ in range(300):
        rig.look()
        readings.append(rig.ranges[LEFT] - 0.7)
    assert np.abs(readings).max() <= 0.03
    assert np.abs(readings).max() > 0.028


@pytest.mark.parametrize("sensors", [PAPER, SIX])
def test_fired_in_turn_only_one_sensor_is_new_each_decision(sensors: Sensors) -> None:
    wall = np.array([[-9.0, 1.0, 9.0, 1.0]])
    rig = Rig(walls=wall, sonar=Ultrasonic(sequential=True), sensors=sensors)
    rig.look()
    for step in range(1, 13):
        before = rig.ranges.copy()
        rig.walls[:, [1, 3]] += 0.01
        rig.look()
        changed = np.flatnonzero(rig.ranges != before).tolist()
        turn = step % len(sensors)
        assert changed in ([turn], [])
        assert changed or turn != LEFT


@pytest.mark.parametrize(("chance", "share"), [(0.0, 0.0), (0.3, 0.3), (1.0, 1.0)])
def test_with_cross_talk_a_sensor_hears_its_neighbour_s_nearer_echo(
    chance: float, share: float
) -> None:
    sonar = Ultrasonic(noise_m=0.0, cross_talk=chance)
    rig = Rig((1.0, 0.5), sonar=sonar)
    readings = []
    for _ in range(600):
        rig.look()
        readings.append(rig.ranges.copy())
    left, right = np.transpose(readings)[:2]
    assert np.ptp(left) == 0.0
    assert np.mean(right == left) == pytest.approx(share, abs=0.05)
    assert set(right) <= {left[0], 4.0}


@pytest.mark.parametrize("sensors", [PAPER, SIX])
def test_interpreted_and_compiled_ranges_agree(sensors: Sensors) -> None:
    sonar, wall = Ultrasonic(gaussian=True, cross_talk=0.5), np.array([[-2.0, 1.1, 3.0, 1.0]])
    rig = Rig((1.5, 0.4), (0.5, -1.2), (0.8, 1.0), walls=wall, sonar=sonar, sensors=sensors)
    rig.look()
    ranges, ring = np.zeros(len(sensors)), rig.ring.view(np.recarray)
    robot, people = rig.robots.view(np.recarray)[0], rig.people.view(np.recarray)
    sense_ranges(robot, people, rig.walls, sonar, ring, np.uint64(KEY), 0, ranges)
    assert rig.ranges == pytest.approx(ranges, abs=1e-12)


def test_interpreted_and_compiled_tracks_agree() -> None:
    positions = (2.0, 1.0), (3.0, -0.2), (9.0, 0.0), (-2.0, 0.4), (2.5, 3.0)
    wall = np.array([[1.0, 2.0, 4.0, 2.0]])
    options = {"position_noise_m": 0.05, "velocity_noise_mps": 0.1, "dropout": 0.2}
    compiled = Rig(*positions, walls=wall, latency_steps=1, **options)
    plain = Rig(*positions, walls=wall, latency_steps=1, **options)
    parameters = SensorParameters(QUIET_SONAR, TRACKER._replace(**options), Thresholds())
    history, tracks = plain.history.view(np.recarray), plain.tracks.view(np.recarray)
    for step in range(12):
        for rig in (compiled, plain):
            rig.people["x"] -= 0.1
        compiled.look()
        remember(plain.people.view(np.recarray), history, step)
        robot = plain.robots.view(np.recarray)[0]
        track_people(robot, wall, history, parameters, plain.key, step, tracks)
        for field in ("visible", "pattern", "x", "y", "vx", "vy"):
            assert tracks[field] == pytest.approx(compiled.tracks[field], abs=1e-12)


def rays(space: pymunk.Space, robot: Any, axis_rad: float, sonar: Ultrasonic) -> float:
    """Return the nearest hit of a bundle of rays that fills a sensor's cone."""
    x = robot.x + sonar.mount_radius_m * math.cos(axis_rad)
    y = robot.y + sonar.mount_radius_m * math.sin(axis_rad)
    not_the_robot = pymunk.ShapeFilter(categories=0b01, mask=0b110)
    nearest = sonar.range_m
    for angle in axis_rad + np.linspace(-sonar.half_cone_rad, sonar.half_cone_rad, 1201):
        end = x + sonar.range_m * math.cos(angle), y + sonar.range_m * math.sin(angle)
        hit = space.segment_query_first((x, y), end, 0.0, not_the_robot)
        if hit is not None:
            nearest = min(nearest, hit.alpha * sonar.range_m)
    return nearest


@pytest.mark.parametrize("name", ["Corridor", "Intersection", "Aisle", "Doorway"])
def test_cones_in_closed_form_agree_with_rays_cast_by_pymunk(name: str) -> None:
    sensors = {"ring": "six", "ultrasonic": {"noise_m": 0.0}}
    env: Any = gymnasium.make(f"hazbot_gym/{name}-v1", sensors=sensors)
    env, sonar, heard = env.unwrapped, QUIET_SONAR, 0
    env.reset(seed=3)
    for decision in range(200):
        *_, terminated, truncated, _ = env.step(np.ones(1))
        if terminated or truncated:
            break
        if decision % 25 != 5:
            continue
        world, robot = env._world, env._world.robots.view(np.recarray)[0]
        world._place_bodies()
        for body in world._space.bodies:
            world._space.reindex_shapes_for_body(body)
        for sensor, offset in enumerate(np.radians([15.0, -15.0, 90.0, -90.0, 52.5, -52.5])):
            people = world.people.view(np.recarray)
            cone = cone_at(robot.theta + offset, sonar.half_cone_rad)
            exact = echo(cone, robot, people, world.place.walls, sonar)
            assert rays(world._space, robot, robot.theta + offset, sonar) == pytest.approx(
                exact, abs=0.01
            )
            assert env._ranges[sensor] == pytest.approx(exact, abs=1e-9)
            heard += exact < sonar.range_m
    assert heard > 5
