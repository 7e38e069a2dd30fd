from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from hazbot_gym.core.patterns import (
    Thresholds,
    classify,
    classify_standing,
    classify_walking,
    closest_approach,
)
from hazbot_gym.core.state import (
    BESIDE,
    CONFRONTING,
    CROSSING,
    ENCOUNTERING,
    LEADING,
    NO_PATTERN,
    Floats,
    as_record,
)

THRESHOLDS = Thresholds()
NOMINAL_MPS = 0.5

# Scenarios of docs/paper.md, section 5.1: a person's start and velocity; the robot drives along x.
SCENARIOS = {
    "E*": ((4.479, 0.800), (-0.5, 0.0), ENCOUNTERING),
    "E5.5": ((5.442, 0.800), (-0.5, 0.0), ENCOUNTERING),
    "C*": ((2.750, 4.763), (0.1962, -0.4599), CROSSING),
    "C90": ((3.889, 3.889), (0.0, -0.5), CROSSING),
}


def random_meetings(count: int = 500) -> Floats:
    """Return rows px, py, theta, speed, vx, vy of people around a robot, some of them standing."""
    rng = np.random.default_rng(1)
    return rng.uniform([-3, -3, -4, 0, -1.5, -1.5], [3, 3, 4, 1.5, 1.5, 1.5], (count, 6))


@pytest.mark.parametrize(
    ("position", "velocity", "expected"),
    [
        ((3.0, 0.0), (1.0, 0.0), LEADING),
        ((2.0, 1.9), (1.0, 0.1), LEADING),  # bearing 44 deg
        ((2.0, 2.1), (1.0, 0.1), BESIDE),  # bearing 46 deg
        ((3.0, 0.5), (-1.0, 0.0), CONFRONTING),  # passes at 0.5 m
        ((3.0, 0.7), (-1.0, 0.0), ENCOUNTERING),  # passes at 0.7 m
        # Headings 144 deg apart, relative velocity (-1.5, 0.73): |px wy - py wx|/|w| = 1.46/1.668.
        ((2.0, 0.0), (-1.0, 0.73), ENCOUNTERING),
        # From the other side it comes towards the robot's line: (1.46 - 1.2)/1.668 = 0.16 m.
        ((2.0, -0.8), (-1.0, 0.73), CONFRONTING),
        ((2.0, -2.0), (-1.0, 1.07), CROSSING),  # 133 deg apart, though it would hit
        ((2.0, 2.0), (0.0, -1.0), CROSSING),
        ((2.0, 2.0), (0.0, 2.0), NO_PATTERN),  # across, but going away
        ((1.0, 2.0), (-1.0, 1.0), NO_PATTERN),  # against, but going away
        ((-0.1, 1.0), (1.0, 0.0), NO_PATTERN),  # behind
        ((3.0, 0.0), (-0.29, 0.0), NO_PATTERN),  # stands
    ],
)
def test_meetings_worked_out_by_hand_have_their_pattern(
    position: tuple[float, float], velocity: tuple[float, float], expected: int
) -> None:
    assert classify_walking(*position, 0.0, NOMINAL_MPS, *velocity, THRESHOLDS) == expected


def test_standing_robot_has_no_walking_pattern() -> None:
    assert classify_walking(3.0, 0.0, 0.0, 0.3, -1.0, 0.0, THRESHOLDS) == NO_PATTERN
    assert classify_walking(3.0, 0.0, 0.0, 0.31, -1.0, 0.0, THRESHOLDS) == CONFRONTING


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenarios_of_the_paper_have_their_pattern_at_the_edge_of_social_space(name: str) -> None:
    start, velocity, expected = SCENARIOS[name]
    times = np.arange(0.0, 12.0, 0.01)[:, None]
    relative = np.array(start) + times * (np.array(velocity) - [NOMINAL_MPS, 0.0])
    px, py = relative[np.argmax(np.hypot(*relative.T) <= 3.6)]

    assert math.hypot(px, py) == pytest.approx(3.6, abs=0.02)
    assert classify(px, py, 0.0, NOMINAL_MPS, *velocity, THRESHOLDS) == expected


@pytest.mark.parametrize(
    ("position", "expected"),
    [
        ((2.0, 0.59), CONFRONTING),
        ((2.0, -0.61), ENCOUNTERING),
        ((0.0, 0.5), CONFRONTING),  # just beside: bearing 90 deg
        ((-0.1, 0.5), NO_PATTERN),
    ],
)
def test_standing_person_confronts_if_it_is_in_the_way(
    position: tuple[float, float], expected: int
) -> None:
    assert classify_standing(*position, 0.0, THRESHOLDS) == expected
    assert classify(*position, 0.0, NOMINAL_MPS, 0.2, 0.2, THRESHOLDS) == expected
    assert classify(*position, 0.0, 0.0, 0.0, 0.0, THRESHOLDS) == expected


def test_classify_is_the_walking_rule_for_all_who_walk() -> None:
    meetings = [row for row in random_meetings() if math.hypot(row[4], row[5]) > 0.3]
    labels = [classify(*row, THRESHOLDS) for row in meetings]

    assert labels == [classify_walking(*row, THRESHOLDS) for row in meetings]
    assert set(labels) == {NO_PATTERN, CROSSING, ENCOUNTERING, LEADING, CONFRONTING, BESIDE}


def test_mirrored_world_has_the_same_patterns() -> None:
    for px, py, theta, speed, vx, vy in random_meetings():
        label = classify(px, py, theta, speed, vx, vy, THRESHOLDS)
        assert classify(px, -py, -theta, speed, vx, -vy, THRESHOLDS) == label


def test_turned_world_has_the_same_patterns() -> None:
    c, s = math.cos(2.5), math.sin(2.5)
    for px, py, theta, speed, vx, vy in random_meetings():
        label = classify(px, py, theta, speed, vx, vy, THRESHOLDS)
        turned = (c * px - s * py, s * px + c * py, theta + 2.5, speed)
        assert classify(*turned, c * vx - s * vy, s * vx + c * vy, THRESHOLDS) == label


def test_compiled_code_agrees_with_python() -> None:
    @numba.njit
    def compiled(meetings, thresholds):  # type: ignore[no-untyped-def]
        labels = np.zeros(len(meetings), np.int64)
        for i in range(len(meetings)):
            px, py, theta, speed, vx, vy = meetings[i]
            labels[i] = classify(px, py, theta, speed, vx, vy, thresholds[0])
        return labels

    meetings = random_meetings()

    expected = [classify(*row, THRESHOLDS) for row in meetings]
    assert compiled(meetings, as_record(THRESHOLDS)).tolist() == expected


@pytest.mark.parametrize(
    ("position", "velocity", "expected"),
    [
        ((4.0, 3.0), (-1.0, 0.0), (4.0, 3.0)),
        ((4.0, 3.0), (-2.0, 0.0), (2.0, 3.0)),
        ((4.0, 3.0), (1.0, 0.0), (0.0, 5.0)),  # going away: nearest now
        ((4.0, 3.0), (0.0, 0.0), (0.0, 5.0)),  # no relative motion
        ((0.0, 0.0), (1.0, 1.0), (0.0, 0.0)),
    ],
)
def test_closest_approach_is_where_relative_motion_comes_nearest(
    position: tuple[float, float], velocity: tuple[float, float], expected: tuple[float, float]
) -> None:
    assert closest_approach(*position, *velocity) == pytest.approx(expected)
