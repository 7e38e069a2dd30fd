from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.state import Floats
from hazbot_gym.core.ultrasonic import (
    Ultrasonic,
    cone_at,
    disc_echo,
    may_meet_disc,
    may_meet_segment,
    segment_echo,
)

SENSOR = Ultrasonic()
ALPHA = SENSOR.half_cone_rad
AHEAD = cone_at(0.0, ALPHA)
SPACING_RAD = 2.5e-4  # between the rays of a bundle

ANGLES = st.floats(-math.pi, math.pi)
POINTS = st.tuples(st.floats(0.3, 6.0), ANGLES).map(
    lambda polar: (polar[0] * math.cos(polar[1]), polar[0] * math.sin(polar[1]))
)


def bundle(axis_rad: float, half_cone_rad: float) -> tuple[Floats, Floats]:
    """Return the directions (n,) of rays that fill a cone."""
    rays = math.ceil(2.0 * half_cone_rad / SPACING_RAD)
    angles = axis_rad + np.linspace(-half_cone_rad, half_cone_rad, rays)
    return np.cos(angles), np.sin(angles)


def disc_by_rays(
    center: tuple[float, float], radius: float, axis_rad: float, half_cone_rad: float
) -> float:
    """Return the distance of a disc along the nearest of the rays, or inf."""
    c, s = bundle(axis_rad, half_cone_rad)
    along, aside = center[0] * c + center[1] * s, center[0] * s - center[1] * c
    hits = (np.abs(aside) <= radius) & (along > 0.0)
    distances = along[hits] - np.sqrt(radius**2 - aside[hits] ** 2)
    return float(distances.min(initial=math.inf))


def segment_by_rays(
    start: tuple[float, float], end: tuple[float, float], axis_rad: float, half_cone_rad: float
) -> float:
    """Return the distance of a segment along the nearest of the rays, or inf."""
    c, s = bundle(axis_rad, half_cone_rad)
    sx, sy = end[0] - start[0], end[1] - start[1]
    cross = c * sy - s * sx
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = (start[0] * sy - start[1] * sx) / cross
        along = (start[0] * s - start[1] * c) / cross
    hits = (distances >= 0.0) & (along >= 0.0) & (along <= 1.0)
    return float(distances[hits].min(initial=math.inf))


@settings(max_examples=300)
@given(POINTS, st.floats(0.05, 0.25), ANGLES)
def test_disc_is_as_far_as_a_bundle_of_rays_says(
    center: tuple[float, float], radius: float, axis_rad: float
) -> None:
    echo = disc_echo(*center, radius, cone_at(axis_rad, ALPHA))

    assert echo <= disc_by_rays(center, radius, axis_rad, ALPHA) + 1e-9
    assert echo >= disc_by_rays(center, radius, axis_rad, ALPHA + 1e-3) - 1e-5


@settings(max_examples=300)
@given(POINTS, POINTS, ANGLES)
def test_segment_is_as_far_as_a_bundle_of_rays_says(
    start: tuple[float, float], end: tuple[float, float], axis_rad: float
) -> None:
    length = math.dist(start, end)
    assume(length > 0.1)
    line_m = abs(start[0] * end[1] - start[1] * end[0]) / length  # how far the segment's line is
    assume(line_m > 0.3)  # rays are too coarse for what is seen end-on

    echo = segment_echo(*start, *end, cone_at(axis_rad, ALPHA), 0.0)

    assert echo <= segment_by_rays(start, end, axis_rad, ALPHA) + 1e-9
    slope = echo**2 / line_m if echo < math.inf else 0.0  # of the distance along the segment
    wider = segment_by_rays(start, end, axis_rad, ALPHA + 1e-3)
    assert echo >= wider - 2.0 * SPACING_RAD * slope - 1e-9


@given(POINTS, POINTS, ANGLES)
def test_mirrored_world_gives_the_same_echo(
    start: tuple[float, float], end: tuple[float, float], axis_rad: float
) -> None:
    (x1, y1), (x2, y2) = start, end
    cone, mirrored = cone_at(axis_rad, ALPHA), cone_at(-axis_rad, ALPHA)
    disc = disc_echo(x1, y1, 0.2, cone)
    segment = segment_echo(x1, y1, x2, y2, cone, 0.0)

    assert disc_echo(x1, -y1, 0.2, mirrored) == pytest.approx(disc)
    assert segment_echo(x1, -y1, x2, -y2, mirrored, 0.0) == pytest.approx(segment)
    assert segment_echo(x2, y2, x1, y1, cone, 0.0) == pytest.approx(segment)


@pytest.mark.parametrize(
    ("dx", "dy", "expected"),
    [
        (2.0, 0.0, 1.8),  # straight ahead
        (2.0, 0.5, math.hypot(2.0, 0.5) - 0.2),  # within the cone
        (0.1, 0.1, 0.0),  # the sensor is inside
        (0.0, 1.0, math.inf),
        (-2.0, 0.0, math.inf),  # behind
    ],
)
def test_disc_answers_with_its_nearest_point(dx: float, dy: float, expected: float) -> None:
    assert disc_echo(dx, dy, 0.2, AHEAD) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("segment", "expected"),
    [
        ((2.0, -1.0, 2.0, 1.0), 2.0),  # foot of the perpendicular
        ((2.0, 0.1, 2.0, 1.0), math.hypot(2.0, 0.1)),  # its end
        ((0.0, 1.0, 9.0, 1.0), 1.0 / math.sin(ALPHA)),  # where the cone's edge meets it
        ((0.0, 0.0, 1.0, 1.0), 0.0),  # the sensor touches it
        ((-1.0, -1.0, -1.0, 1.0), math.inf),
        ((1.5, 0.0, 1.5, 0.0), 1.5),  # without length
    ],
)
def test_segment_answers_with_its_nearest_point(
    segment: tuple[float, float, float, float], expected: float
) -> None:
    assert segment_echo(*segment, AHEAD, 0.0) == pytest.approx(expected)


def test_wall_met_at_a_slant_reflects_the_pulse_away() -> None:
    keen = math.cos(math.radians(60.0))
    # A wall to the left along the axis is met by the cone's edge at 90 - 15 = 75 deg.
    along = (0.0, 1.0, 9.0, 1.0)

    assert segment_echo(*along, AHEAD, 0.0) < 4.0
    assert segment_echo(*along, AHEAD, keen) == math.inf
    assert segment_echo(*along, AHEAD, math.cos(math.radians(75.1))) < 4.0
    assert segment_echo(2.0, -1.0, 2.0, 1.0, AHEAD, keen) == 2.0
    for slant_deg, expected in ((59.0, True), (61.0, False)):
        t = math.tan(math.radians(slant_deg))  # begins straight ahead, the nearer end
        echo = segment_echo(2.0, 0.0, 2.0 + t, 1.0, AHEAD, keen)
        assert math.isfinite(echo) is expected


@settings(max_examples=300)
@given(POINTS, POINTS, st.floats(0.05, 0.25), ANGLES)
def test_what_is_sorted_out_beforehand_gives_no_echo(
    start: tuple[float, float], end: tuple[float, float], radius: float, axis_rad: float
) -> None:
    cone = cone_at(axis_rad, ALPHA)

    if not may_meet_disc(*start, radius, cone):
        assert disc_echo(*start, radius, cone) == math.inf
    if not may_meet_segment(*start, *end, cone):
        assert segment_echo(*start, *end, cone, 0.0) == math.inf


@kernel
def compiled_echoes(rows: Floats, cos_miss: float, out: Floats) -> None:
    for i in range(rows.shape[0]):
        x1, y1, x2, y2, axis = rows[i]
        cone = cone_at(axis, ALPHA)
        out[i, 0] = disc_echo(x1, y1, 0.2, cone)
        out[i, 1] = segment_echo(x1, y1, x2, y2, cone, cos_miss)


def test_compiled_code_agrees_with_python() -> None:
    rows = np.random.default_rng(2).uniform(-3.0, 3.0, (1000, 5))
    cos_miss = math.cos(1.0)
    out = np.empty((1000, 2))
    compiled_echoes(rows, cos_miss, out)

    expected = [
        (disc_echo(*row[:2], 0.2, cone), segment_echo(*row[:4], cone, cos_miss))
        for row in rows.tolist()
        for cone in (cone_at(row[4], ALPHA),)
    ]
    assert np.isfinite(out).sum(axis=0).min() > 50
    assert out == pytest.approx(np.array(expected), rel=1e-12)
