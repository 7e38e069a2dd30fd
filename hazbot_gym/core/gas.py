"""Gas plume of a leak in a corridor with a draught, as a closed form of filaments.

Farrell, Murlis, Long, Li and Carde (2002, Filament-based atmospheric dispersion model): a leak
releases filaments at a constant rate; the wind carries them, and each grows, sigma_f^2 = sigma_0^2
+ gamma tau. Here the wind is a constant draught U along the corridor and a lateral meander v(t),
equal everywhere, and the centers of filaments diffuse across it, s^2 = 2 D tau in both directions,
with the travel time tau = d / U at a distance d downwind. The sum over filaments then has a closed
form: a Gaussian around the meandering centerline, which the walls reflect, times a fluctuation for
the finite number of filaments:

    c = S A(d) sigma(1 m)^2 / sigma^2 sum_k exp(-(y - Y_k)^2 / 2 sigma^2) F
    sigma^2 = sigma_f^2 + s^2 = sigma_0^2 + (gamma + 2 D) d / U
    Y = y_0 + integral of v from t - d / U to t,  v = sum_m v_m cos(w_m t + phi_m)

with the center's images Y_k, the edge A(d) = Phi(d / sigma_f) at the leak, and a lognormal F of
mean 1 whose variance is that of a Poisson process of filaments (Campbell's theorem). The draught
carries F along: it depends on the time of release t - d / U.

Leak and sensor are at the same height, and floor and ceiling are far. Distances along the corridor
are arc lengths of the robot's path. The leak has been open for long. Nothing depends on the robot.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from hazbot_gym.core.elementary import decay, sin_cos
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.noise import GAS_FIELD, normal_pair, uniform4
from hazbot_gym.core.state import LeakRecord

REFERENCE_M = 1.0  # distance downwind at which a leak's strength is stated
OVERTONES = (1.0, 2.3, 5.1)  # frequencies of the meander / the lowest, incommensurate
LARGEST_VARIANCE = 4.0  # of F, far from the centerline
_BEFORE = 1 << 20  # bins of the fluctuation before time 0
_ROOT_PI = math.sqrt(math.pi)
_ROOT_2 = math.sqrt(2.0)


class Plume(NamedTuple):
    """Dispersion of gas; the filaments' numbers are those of open simulators (GADEN)."""

    filaments_per_s: Annotated[float, Gt(0)] = 10.0
    sigma0_m: Annotated[float, Ge(0.001)] = 0.1  # sigma_0, of a fresh filament
    growth_m2ps: Annotated[float, Ge(0)] = 0.001  # gamma
    mixing_m2ps: Annotated[float, Ge(0)] = 0.003  # D, of the filaments' centers; our choice
    meander_mps: Annotated[float, Ge(0)] = 0.15  # root mean square of v; our choice
    meander_s: Annotated[float, Gt(0)] = 30.0  # longest period of v; our choice


@scalar
def concentration(
    leak: LeakRecord, plume: Plume, s_m: float, y_m: float, t_s: float, key: np.uint64
) -> float:
    """Return the concentration c [ppm] at a point of the corridor.

    Args:
        leak: Record of type ``LEAK``.
        plume: Dispersion.
        s_m: Arc length of the path.
        y_m: Lateral position, left of the path positive.
        t_s: Time since the reset.
        key: Key of the scenario's noise.
    """
    if leak.is_there == 0:
        return 0.0
    mean_ppm, variance, travel_s = plume_moments(leak, plume, s_m, y_m, t_s)
    if mean_ppm == 0.0:
        return 0.0
    spread2 = math.log(1.0 + variance)  # variance of log F
    bin_s = 2.0 * plume.sigma0_m / abs(leak.draught_mps)
    g = fluctuation((t_s - travel_s) / bin_s, key)
    return mean_ppm * math.exp(math.sqrt(spread2) * g - 0.5 * spread2)


@scalar
def plume_moments(
    leak: LeakRecord, plume: Plume, s_m: float, y_m: float, t_s: float
) -> tuple[float, float, float]:
    """Return mean [ppm] and relative variance of c for a given meander, and the travel time [s]."""
    speed_mps = abs(leak.draught_mps)
    along_m = (s_m - leak.s_m) * (1.0 if leak.draught_mps > 0.0 else -1.0)
    travel_s = max(along_m, 0.0) / speed_mps
    filament2, centers2 = spread(plume, travel_s)
    filament_m = math.sqrt(filament2)
    if along_m < -6.0 * filament_m:
        return 0.0, 0.0, 0.0
    edge = 0.5 * (1.0 + math.erf(along_m / (_ROOT_2 * filament_m)))
    center_m = leak.y_m + meander(leak, plume, t_s) - meander(leak, plume, t_s - travel_s)
    across, offset_m = profile(center_m, y_m, leak.left_m, leak.right_m, filament2 + centers2)
    reference_f2, reference_s2 = spread(plume, REFERENCE_M / speed_mps)
    dilution = (reference_f2 + reference_s2) / (filament2 + centers2)
    variance = relative_variance(filament2, centers2, offset_m, plume.filaments_per_s / speed_mps)
    return leak.strength_ppm * edge * across * dilution, variance, travel_s


@scalar
def spread(plume: Plume, travel_s: float) -> tuple[float, float]:
    """Return sigma_f^2 of a filament and s^2 of the filaments' centers [m^2]."""
    filament2 = plume.sigma0_m * plume.sigma0_m + plume.growth_m2ps * travel_s
    return filament2, 2.0 * plume.mixing_m2ps * travel_s


@scalar
def relative_variance(
    filament2: float, centers2: float, offset_m: float, filaments_per_m: float
) -> float:
    """Return Var(c) / c^2 of a Poisson process of filaments (Campbell's theorem).

    With n filaments per metre along the draught and an offset y from the centerline:

        L / (2 sqrt(pi) sigma_f n),  L = sigma^4 / (2 p^2 sigma_f^2) exp(y^2 (1/sigma^2 - 1/2p^2))

    with sigma^2 = sigma_f^2 + s^2 and p^2 = sigma_f^2 / 2 + s^2; L = 1 without diffusion of the
    centers. Bounded far from the centerline.
    """
    total2, pair2 = filament2 + centers2, 0.5 * filament2 + centers2
    exponent = offset_m * offset_m * (1.0 / total2 - 0.5 / pair2)
    filament_m = math.sqrt(filament2)
    lateral = total2 * total2 / (2.0 * pair2 * filament2 * decay(-exponent))
    return min(lateral / (2.0 * _ROOT_PI * filament_m * filaments_per_m), LARGEST_VARIANCE)


@scalar
def meander(leak: LeakRecord, plume: Plume, t_s: float) -> float:
    """Return the integral of the lateral wind v, up to a constant [m].

    Three components of equal strength, v_m^2 / 2 = v_rms^2 / 3, at incommensurate frequencies.
    """
    amplitude = plume.meander_mps * math.sqrt(2.0 / 3.0)
    w = 2.0 * math.pi / plume.meander_s
    w2, w3 = OVERTONES[1] * w, OVERTONES[2] * w
    return amplitude * (
        sin_cos(w * t_s + leak.phase_1)[0] / w
        + sin_cos(w2 * t_s + leak.phase_2)[0] / w2
        + sin_cos(w3 * t_s + leak.phase_3)[0] / w3
    )


@scalar
def profile(
    center_m: float, y_m: float, left_m: float, right_m: float, total2: float
) -> tuple[float, float]:
    """Return the Gaussian across the plume, 1 on its centerline, and the offset from it [m].

    Walls reflect the center, and add images of it.
    """
    width_m = left_m + right_m
    if math.isinf(width_m):
        if center_m > left_m:
            center_m = 2.0 * left_m - center_m
        elif center_m < -right_m:
            center_m = -2.0 * right_m - center_m
    else:
        turns = math.floor((center_m + right_m) / (2.0 * width_m))
        beyond_m = center_m + right_m - 2.0 * width_m * turns  # from the right wall, 0 to 2 widths
        center_m = min(beyond_m, 2.0 * width_m - beyond_m) - right_m
    value = _bell(y_m - center_m, total2)
    if not math.isinf(left_m):
        value += _bell(y_m - 2.0 * left_m + center_m, total2)
    if not math.isinf(right_m):
        value += _bell(y_m + 2.0 * right_m + center_m, total2)
    if not math.isinf(width_m):
        value += _bell(y_m - center_m - 2.0 * width_m, total2)
        value += _bell(y_m - center_m + 2.0 * width_m, total2)
    return value, y_m - center_m


@scalar
def _bell(y_m: float, variance: float) -> float:
    return decay(-0.5 * y_m * y_m / variance)


@scalar
def fluctuation(bins: float, key: np.uint64) -> float:
    """Return a standard normal number that varies smoothly over bins of the time of release.

    g = a_k cos(q) + a_(k+1) sin(q), with independent normal a_k at the bounds of bins and q from 0
    to pi/2 within a bin: variance 1 everywhere, and a correlation of 1/e at 0.93 bins.
    """
    k = math.floor(bins)
    sine, cosine = sin_cos(0.5 * math.pi * (bins - k))
    return cosine * _normal_of(k, key) + sine * _normal_of(k + 1, key)


@scalar
def _normal_of(k: float, key: np.uint64) -> float:
    u1, u2, _, _ = uniform4(key, GAS_FIELD, int(k) + _BEFORE, 0)
    return normal_pair(u1, u2)[0]
