"""The closed form of the plume, against filaments that are followed one by one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.gas import (
    LARGEST_VARIANCE,
    Plume,
    concentration,
    meander,
    plume_moments,
    profile,
    spread,
)
from hazbot_gym.core.jit import lean_kernel
from hazbot_gym.core.state import LEAK, Floats, Records, as_record, records

KEY = np.uint64(20_26)
STILL = Plume(meander_mps=0.0)
LASTS_S, STEP_S = 1200.0, 0.1
OPEN = math.inf


def a_leak(**fields: float) -> Records:
    """Return a leak in an open place, with a draught along the path, unless said otherwise."""
    leaks = records(LEAK, 1)
    usual = {"is_there": 1, "strength_ppm": 20.0, "draught_mps": 0.3, "phase_1": 1.0}
    usual |= {"left_m": math.inf, "right_m": math.inf, "phase_2": 4.0, "phase_3": 2.5}
    for name, value in {**usual, **fields}.items():
        leaks[name] = value
    return leaks


@lean_kernel
def _over_time(
    leaks: Records, plumes: Records, points: Floats, times: Floats, key: np.uint64, out: Floats
) -> None:
    for i in range(times.shape[0]):
        for k in range(points.shape[0]):
            s, y = points[k, 0], points[k, 1]
            out[i, k] = concentration(leaks[0], plumes[0], s, y, times[i], key)


def closed_form(leaks: Records, plume: Plume, points: Floats, times: Floats) -> Floats:
    """Return the concentration at times and points (T, K) [ppm]."""
    out = np.empty((len(times), len(points)))
    _over_time(leaks, as_record(plume), points, times, KEY, out)
    return out


def wind_way(leaks: Records, plume: Plume, times: Floats) -> Floats:
    """Return the way of the lateral wind up to each time [m]."""
    return np.array([meander(leaks.view(np.recarray)[0], plume, t) for t in times])


def folded(y: Floats, left_m: float, right_m: float) -> Floats:
    """Return lateral positions after all reflections at walls that are there."""
    if math.isinf(left_m + right_m):
        y = np.where(y > left_m, 2.0 * left_m - y, y)
        return np.where(y < -right_m, -2.0 * right_m - y, y)
    width = left_m + right_m
    beyond = np.mod(y + right_m, 2.0 * width)
    return np.minimum(beyond, 2.0 * width - beyond) - right_m


def filaments(leaks: Records, plume: Plume, points: Floats, times: Floats) -> Floats:
    """Return the concentration of a Poisson process of filaments, at times and points (T, K).

    Farrell et al. (2002): each is carried by the draught and the lateral wind, takes its own random
    walk across in two directions, and is a Gaussian puff in space. Walls reflect the centers and
    the puffs. Leak and points are at the same height.
    """
    leak, rng = leaks[0], np.random.default_rng(7)
    speed, farthest = leak["draught_mps"], points[:, 0].max() + 1.0
    lives_s = farthest / speed
    first, last = times[0] - lives_s, times[-1]
    born = np.sort(rng.uniform(first, last, rng.poisson(plume.filaments_per_s * (last - first))))
    own = np.zeros((len(born), 2))  # across and up, by their own random walks
    per_m = plume.filaments_per_s / speed
    peak = leak["strength_ppm"] * sum(spread(plume, 1.0 / speed)) / math.sqrt(2.0 * math.pi) / per_m
    way = wind_way(leaks, plume, times)
    way_born = wind_way(leaks, plume, born)
    step_s, out = float(times[1] - times[0]), np.empty((len(times), len(points)))
    for i, t in enumerate(times):
        begin, end = np.searchsorted(born, [t - lives_s, t])
        age = t - born[begin:end]
        walked = np.sqrt(2.0 * plume.mixing_m2ps * np.minimum(age, step_s if i else lives_s))
        own[begin:end] += walked[:, None] * rng.standard_normal((end - begin, 2))
        up = own[begin:end, 1]
        y = folded(
            leak["y_m"] + way[i] - way_born[begin:end] + own[begin:end, 0],
            leak["left_m"], leak["right_m"],
        )  # fmt: skip
        size2 = plume.sigma0_m**2 + plume.growth_m2ps * age
        along2 = (points[:, 0, None] - leak["s_m"] - speed * age) ** 2
        images = [y]
        images += [2.0 * leak["left_m"] - y] if np.isfinite(leak["left_m"]) else []
        images += [-2.0 * leak["right_m"] - y] if np.isfinite(leak["right_m"]) else []
        puffs = sum(
            np.exp(-((points[:, 1, None] - each) ** 2 + along2 + up**2) / (2.0 * size2))
            for each in images
        )
        out[i] = (peak / size2**1.5 * puffs).sum(axis=1)
    return out


class Both(NamedTuple):
    """Concentrations of both, at equal times and points (T, K) [ppm]."""

    filaments: Floats
    closed: Floats


def compared(leaks: Records, plume: Plume, points: list[tuple[float, float]]) -> Both:
    times, at = np.arange(0.0, LASTS_S, STEP_S), np.array(points)
    return Both(*(form(leaks, plume, at, times) for form in (filaments, closed_form)))


BESIDE = [(0.5, 0.1), (1.0, 0.0), (1.0, 0.15), (2.0, 0.0), (2.0, 0.25), (4.0, 0.0), (4.0, 0.35)]
CENTERLINE = [1, 3, 5]


@pytest.fixture(scope="module")
def still() -> Both:
    """Return both without meander, on the centerline and beside it."""
    return compared(a_leak(), STILL, BESIDE)


# --- held to filaments ---------------------------------------------------------------------------


def test_mean_over_time_is_that_of_filaments(still: Both) -> None:
    mean = still.filaments.mean(axis=0)
    assert still.closed.mean(axis=0) == pytest.approx(mean, rel=0.06)
    assert mean.max() > 6.0 * mean.min()


@pytest.mark.parametrize(
    ("left_m", "right_m", "y_m"),
    [(OPEN, OPEN, 0.0), (1.2, 1.2, 0.3), (0.6, OPEN, 0.3), (OPEN, 0.5, -0.2)],
    ids=["open", "corridor", "wall on the left", "wall on the right"],
)
def test_mean_over_time_is_that_of_filaments_that_meander_between_walls(
    left_m: float, right_m: float, y_m: float
) -> None:
    leaks = a_leak(left_m=left_m, right_m=right_m, y_m=y_m)
    points = [(1.0, 0.0), (2.0, 0.5), (3.0, -0.4), (4.0, 0.0), (6.0, 0.55), (6.0, -0.45)]
    both = compared(leaks, Plume(), points)

    assert both.closed.mean(axis=0) == pytest.approx(both.filaments.mean(axis=0), rel=0.08)
    for k in range(len(points)):  # the meander passes a point at the same moments
        assert np.corrcoef(both.closed[:, k], both.filaments[:, k])[0, 1] > 0.4


def test_relative_variance_is_that_of_filaments(still: Both) -> None:
    leak = a_leak().view(np.recarray)[0]
    campbell = [plume_moments(leak, STILL, s, y, 0.0)[1] for s, y in BESIDE]
    for found in still:
        assert found.var(axis=0) / found.mean(axis=0) ** 2 == pytest.approx(campbell, rel=0.15)
    assert max(campbell) > 2.0 * min(campbell)


def test_gas_comes_in_whiffs_as_long_as_those_of_filaments(still: Both) -> None:
    """Up to the growth of filaments, which the whiffs of the closed form do not follow."""
    for k in CENTERLINE:
        measured, lasting = (whiff_s(found[:, k]) for found in still)
        assert 0.6 * measured < lasting < 1.05 * measured


def whiff_s(values: Floats) -> float:
    """Return the time after which the autocorrelation has fallen to 1 / e [s]."""
    rest = values - values.mean()
    spectrum = np.abs(np.fft.rfft(rest, 2 * len(rest))) ** 2
    correlation = np.fft.irfft(spectrum)[:100]
    return STEP_S * float(np.interp(-1.0 / math.e, -correlation / correlation[0], np.arange(100)))


def test_whiffs_are_carried_by_the_draught(still: Both) -> None:
    late = round(1.0 / 0.3 / STEP_S)  # from 1 m to 2 m
    for found in still:
        near, far = found[:, 1], found[:, 3]
        assert np.corrcoef(near[:-late], far[late:])[0, 1] > 0.5
        assert abs(np.corrcoef(near, far)[0, 1]) < 0.2


# --- properties ----------------------------------------------------------------------------------


def at(leaks: Records, s_m: float, y_m: float, t_s: float, key: int = 1) -> float:
    return concentration(leaks.view(np.recarray)[0], Plume(), s_m, y_m, t_s, np.uint64(key))


@pytest.mark.parametrize("draught_mps", [0.3, -0.3])
def test_upwind_there_is_nothing(draught_mps: float) -> None:
    leaks, against = a_leak(draught_mps=draught_mps), -np.sign(draught_mps)
    for t in np.arange(0.0, 30.0, 0.7):
        assert at(leaks, 0.3 * against, 0.0, t) < 0.05 * 20.0
        assert at(leaks, 0.7 * against, 0.0, t) == 0.0
        assert at(leaks, -0.7 * against, 0.0, t) > 0.0


def test_without_a_leak_the_air_is_clean() -> None:
    assert at(a_leak(is_there=0), 1.0, 0.0, 1.0) == 0.0


@pytest.mark.parametrize("draught_mps", [0.2, -0.5])
def test_strength_is_the_value_on_the_centerline_1_m_downwind(draught_mps: float) -> None:
    leak = a_leak(s_m=4.0, y_m=0.3, draught_mps=draught_mps).view(np.recarray)[0]
    for t in (0.0, 3.3, 60.0):
        way = meander(leak, Plume(), t) - meander(leak, Plume(), t - 1.0 / abs(draught_mps))
        s = 4.0 + math.copysign(1.0, draught_mps)
        assert plume_moments(leak, Plume(), s, 0.3 + way, t)[0] == pytest.approx(20.0, rel=1e-9)


def test_equal_keys_have_equal_gas_and_others_have_other_whiffs() -> None:
    times = np.arange(0.0, 20.0, 0.5)
    first, again, other = ([at(a_leak(), 2.0, 0.0, t, key) for t in times] for key in (5, 5, 6))
    assert first == again
    assert not np.isclose(first, other, rtol=0.01).all()
    assert np.abs(np.corrcoef(np.log(first), np.log(other))[0, 1]) < 0.999


@given(
    st.tuples(*[st.floats(-40.0, 40.0)] * 2, *[st.floats(-5.0, 5.0)] * 2),
    st.tuples(*[st.one_of(st.floats(0.1, 5.0), st.just(OPEN))] * 2),
    st.floats(0.0, 3600.0),
    st.floats(0.01, 3.0),
    st.booleans(),
    st.builds(
        Plume,
        *[st.floats(0.1, 100.0), st.floats(0.01, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0)],
        *[st.floats(0.0, 3.0), st.floats(0.5, 300.0)],
    ),
)
def test_concentration_is_finite_and_not_negative(
    where: tuple[float, float, float, float],
    walls: tuple[float, float],
    t_s: float,
    speed_mps: float,
    is_against: bool,
    plume: Plume,
) -> None:
    leak_s, s, leak_y, y = where
    draught = -speed_mps if is_against else speed_mps
    leaks = a_leak(s_m=leak_s, y_m=leak_y, draught_mps=draught, left_m=walls[0], right_m=walls[1])
    leak = leaks.view(np.recarray)[0]

    value = concentration(leak, plume, s, y, t_s, KEY)
    mean, variance, travel_s = plume_moments(leak, plume, s, y, t_s)
    assert 0.0 <= value < math.inf
    assert 0.0 <= mean < math.inf
    assert 0.0 <= variance <= LARGEST_VARIANCE
    assert travel_s >= 0.0


@given(st.floats(-20.0, 20.0), st.floats(0.2, 3.0), st.floats(0.2, 3.0), st.floats(0.01, 0.3))
def test_walls_keep_all_of_the_gas(
    center_m: float, left_m: float, right_m: float, sigma_m: float
) -> None:
    """Wherever the meander has carried the centerline."""
    across = np.linspace(-right_m, left_m, 401)
    values = [profile(center_m, y, left_m, right_m, sigma_m**2)[0] for y in across]
    assert np.trapezoid(values, across) == pytest.approx(math.sqrt(2.0 * math.pi) * sigma_m, 0.02)
