"""Counter-based noise: every random number is a pure function of (key, stream, step, index).

So noise does not depend on the policy's actions, both engines agree, and worlds can be stepped in
any order. The generator is Philox4x32-10 (Salmon, Moraes, Dror and Shaw 2011, "Parallel random
numbers: as easy as 1, 2, 3"), checked against its published known answers.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.core.jit import scalar

# Streams: consumers of noise. A new consumer takes a new number; existing numbers are fixed.
SCENARIO, WHEELS, SONAR, TRACKER, CROWD = 1, 2, 3, 4, 5
LEAK_DRAW, GAS_FIELD, GAS_READING, CONFIG, ROBOT_STARTS = 6, 7, 8, 9, 10

_MULTIPLIER_0 = np.uint64(0xD2511F53)
_MULTIPLIER_1 = np.uint64(0xCD9E8D57)
_WEYL_0 = np.uint64(0x9E3779B9)
_WEYL_1 = np.uint64(0xBB67AE85)
_LOW = np.uint64(0xFFFFFFFF)
_SHIFT = np.uint64(32)
_TO_UNIT = 1.0 / 4294967296.0
_SQRT_3 = math.sqrt(3.0)


@scalar
def philox4x32(
    c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, key: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return four 32-bit words for a counter of four 32-bit words and a 64-bit key (10 rounds)."""
    k0 = key & _LOW
    k1 = key >> _SHIFT
    for _ in range(10):
        product_0 = _MULTIPLIER_0 * c0
        product_1 = _MULTIPLIER_1 * c2
        c0, c1, c2, c3 = (
            (product_1 >> _SHIFT) ^ c1 ^ k0,
            product_1 & _LOW,
            (product_0 >> _SHIFT) ^ c3 ^ k1,
            product_0 & _LOW,
        )
        k0 = (k0 + _WEYL_0) & _LOW
        k1 = (k1 + _WEYL_1) & _LOW
    return c0, c1, c2, c3


@scalar
def uniform4(
    key: np.uint64, stream: int, step: int, index: int
) -> tuple[float, float, float, float]:
    """Return four independent uniform numbers in (0, 1), on a grid of 2^-32."""
    a, b, c, d = philox4x32(np.uint64(step), np.uint64(index), np.uint64(stream), np.uint64(0), key)
    return (
        (np.float64(a) + 0.5) * _TO_UNIT,
        (np.float64(b) + 0.5) * _TO_UNIT,
        (np.float64(c) + 0.5) * _TO_UNIT,
        (np.float64(d) + 0.5) * _TO_UNIT,
    )


@scalar
def uniform_noise(u: float) -> float:
    """Return zero-mean noise of standard deviation 1 from a uniform number: sqrt(3) (2 u - 1)."""
    return _SQRT_3 * (2.0 * u - 1.0)


@scalar
def normal_pair(u1: float, u2: float) -> tuple[float, float]:
    """Return two independent standard normal numbers from two uniform ones (Box, Muller 1958)."""
    radius = math.sqrt(-2.0 * math.log(u1))
    angle = 2.0 * math.pi * u2
    return radius * math.cos(angle), radius * math.sin(angle)


@scalar
def noise_value(u1: float, u2: float, half_width: float, is_gaussian: bool) -> float:
    """Return zero-mean sensor noise of a half width.

    Uniform in +-half_width, or Gaussian with sigma = half_width / 2.
    """
    if is_gaussian:
        return 0.5 * half_width * normal_pair(u1, u2)[0]
    return half_width * (2.0 * u1 - 1.0)
