from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.social_force import (
    SocialForce,
    elliptical_repulsion,
    goal_force,
    sidestep_force,
    view_weight,
    wall_force,
)
from hazbot_gym.core.state import Floats, Records, as_record

FORCE = SocialForce()
SIDESTEP = (FORCE.sidestep_mps2, FORCE.sidestep_range_m)
STRENGTH, RANGE_M = FORCE.person_strength_mps2, FORCE.person_range_m

METRES = st.floats(-3.0, 3.0)
POINTS = st.tuples(METRES, METRES)
ANGLES = st.floats(-math.pi, math.pi)


def half_axis(rx: float, ry: float, sx: float, sy: float) -> float:
    """Return b, the ellipse's shorter half axis (Helbing and Molnar 1995, eq 4)."""
    total = math.hypot(rx, ry) + math.hypot(rx - sx, ry - sy)
    return 0.5 * math.sqrt(max(total**2 - sx**2 - sy**2, 0.0))


def potential(rx: float, ry: float, sx: float, sy: float) -> float:
    """Return V(b) (eq 3) with V0 = strength * sigma."""
    return STRENGTH * RANGE_M * math.exp(-half_axis(rx, ry, sx, sy) / RANGE_M)


def repulsion(r: tuple[float, float], step: tuple[float, float]) -> tuple[float, float]:
    return elliptical_repulsion(*unit(r), *step, STRENGTH, RANGE_M)


def unit(r: tuple[float, float]) -> tuple[float, float, float]:
    """Return a vector's direction and length."""
    length = max(math.hypot(*r), 1e-6)
    return r[0] / length, r[1] / length, length


def mirrored(vector: tuple[float, float]) -> tuple[float, float]:
    return vector[0], -vector[1]


@given(POINTS, POINTS)
def test_repulsion_is_the_gradient_of_the_potential(
    r: tuple[float, float], step: tuple[float, float]
) -> None:
    h = 1e-6
    (x, y), total = r, math.hypot(*r) + math.dist(r, step)
    assume(min(math.hypot(*r), math.dist(r, step)) > 0.1)
    # Where the ellipse is flat the gradient grows without bound, and the force is held back.
    b = half_axis(*r, *step)
    assume(b > 0.1)
    assume(math.exp(-b / RANGE_M) * total < 4.0 * b)
    slopes = (
        (potential(x - h, y, *step) - potential(x + h, y, *step)) / (2.0 * h),
        (potential(x, y - h, *step) - potential(x, y + h, *step)) / (2.0 * h),
    )

    assert repulsion(r, step) == pytest.approx(slopes, rel=1e-4, abs=1e-6)


@given(POINTS, POINTS)
def test_repulsion_is_bounded_and_mirrors(
    r: tuple[float, float], step: tuple[float, float]
) -> None:
    force = repulsion(r, step)

    assert math.hypot(*force) <= 2.0 * STRENGTH + 1e-9
    assert repulsion(mirrored(r), mirrored(step)) == pytest.approx(mirrored(force))


@given(POINTS)
def test_without_a_step_repulsion_is_central_and_exponential(r: tuple[float, float]) -> None:
    distance = math.hypot(*r)
    assume(distance > 0.01)
    fx, fy = repulsion(r, (0.0, 0.0))

    assert math.hypot(fx, fy) == pytest.approx(STRENGTH * math.exp(-distance / RANGE_M), rel=1e-3)
    assert fx * r[1] == pytest.approx(fy * r[0], abs=1e-9)
    assert fx * r[0] + fy * r[1] >= 0.0


def test_who_comes_nearer_repels_more_than_who_goes_away() -> None:
    r = (-1.0, 0.2)  # the other is ahead, to the right

    coming, standing, going = (math.hypot(*repulsion(r, (step, 0.0))) for step in (-0.9, 0.0, 0.9))
    assert coming > standing > going


def test_two_on_the_same_spot_get_a_finite_push() -> None:
    assert all(math.isfinite(value) for value in repulsion((0.0, 0.0), (0.0, 0.0)))


@given(st.floats(0.1, 2.0), st.floats(0.3, 1.0))
def test_goal_force_brings_the_speed_to_the_desired_one(desired: float, tau_s: float) -> None:
    vx, vy, dt_s = 0.3, -0.4, 0.001
    for _ in range(round(8.0 * tau_s / dt_s)):
        ax, ay = goal_force(vx, vy, 0.6, 0.8, desired, tau_s)
        vx, vy = vx + ax * dt_s, vy + ay * dt_s

    assert (vx, vy) == pytest.approx((0.6 * desired, 0.8 * desired), abs=1e-3)


@pytest.mark.parametrize(
    ("bearing_deg", "expected"), [(0.0, 1.0), (99.0, 1.0), (-99.0, 1.0), (101.0, 0.5), (180.0, 0.5)]
)
def test_what_is_out_of_view_counts_half(bearing_deg: float, expected: float) -> None:
    bearing = math.radians(bearing_deg)
    push = (-3.0 * math.cos(bearing), -3.0 * math.sin(bearing))  # away from its cause

    assert view_weight(1.0, 0.0, *push, FORCE) == expected


def test_no_force_is_in_view() -> None:
    assert view_weight(1.0, 0.0, 0.0, 0.0, FORCE) == 1.0


def test_wall_pushes_along_its_normal_and_no_harder_than_at_a_touch() -> None:
    normal = (0.6, -0.8)

    assert wall_force(*normal, 0.0, 10.0, 0.1) == pytest.approx((6.0, -8.0))
    assert wall_force(*normal, -0.1, 10.0, 0.1) == pytest.approx((6.0, -8.0))
    assert wall_force(*normal, 0.1, 10.0, 0.1) == pytest.approx((6.0 / math.e, -8.0 / math.e))


@pytest.mark.parametrize(
    ("left_m", "side"),
    [(0.5, -1.0), (-0.5, 1.0), (0.0, -1.0), (-1e-4, -1.0)],  # in doubt to the right
)
def test_walker_steps_to_the_side_on_which_it_already_is(left_m: float, side: float) -> None:
    ax, ay = sidestep_force(*unit((2.0, left_m))[:2], 1.0, 0.0, 1.5, *SIDESTEP)

    assert ax == 0.0
    assert math.copysign(1.0, ay) == side
    assert abs(ay) > 0.1


@given(ANGLES, ANGLES, st.floats(0.0, 5.0))
def test_sidestep_is_across_the_way_and_bounded(
    bearing: float, course: float, gap_m: float
) -> None:
    assume(abs(math.sin(bearing)) > 0.01)
    n = (math.cos(course + bearing), math.sin(course + bearing))
    e = (math.cos(course), math.sin(course))
    ax, ay = sidestep_force(*n, *e, gap_m, *SIDESTEP)

    assert ax * e[0] + ay * e[1] == pytest.approx(0.0, abs=1e-9)
    assert math.hypot(ax, ay) <= FORCE.sidestep_mps2 + 1e-9
    assert sidestep_force(*mirrored(n), *mirrored(e), gap_m, *SIDESTEP) == pytest.approx(
        mirrored((ax, ay))
    )
    if gap_m >= FORCE.sidestep_range_m or math.cos(bearing) <= 0.0:
        assert (ax, ay) == (0.0, 0.0)


def test_sidestep_grows_as_the_obstacle_comes_near_and_lies_ahead() -> None:
    def strength(left_m: float, gap_m: float) -> float:
        return math.hypot(*sidestep_force(*unit((2.0, left_m))[:2], 1.0, 0.0, gap_m, *SIDESTEP))

    assert strength(0.1, 0.5) > strength(0.1, 1.5) > strength(0.1, 2.9) > 0.0
    assert strength(0.1, 1.0) > strength(1.0, 1.0) > strength(3.0, 1.0) > 0.0
    assert strength(0.0, 0.0) == FORCE.sidestep_mps2


@kernel
def compiled_forces(rows: Floats, force: Records, out: Floats) -> None:
    for i in range(len(rows)):
        rx, ry, sx, sy = rows[i]
        r = math.sqrt(rx * rx + ry * ry)
        fx, fy = elliptical_repulsion(rx / r, ry / r, r, sx, sy, 7.0, 0.3)
        out[i, 0], out[i, 1] = fx, fy
        out[i, 2] = view_weight(0.6, 0.8, fx, fy, force[0])
        out[i, 3], out[i, 4] = sidestep_force(rx / r, ry / r, 0.6, 0.8, abs(sx), 0.812, 3.0)


def test_compiled_code_agrees_with_python() -> None:
    rows = np.random.default_rng(3).uniform(-2.0, 2.0, (300, 4))
    out = np.empty((300, 5))
    compiled_forces(rows, as_record(FORCE), out)

    for (rx, ry, sx, sy), row in zip(rows.tolist(), out, strict=True):
        nx, ny, r = unit((rx, ry))
        push = elliptical_repulsion(nx, ny, r, sx, sy, 7.0, 0.3)
        weight = view_weight(0.6, 0.8, *push, FORCE)
        step = sidestep_force(nx, ny, 0.6, 0.8, abs(sx), 0.812, 3.0)
        assert row == pytest.approx([*push, weight, *step], rel=1e-12, abs=1e-15)
