from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.core.elementary import DEEPEST, decay, sin_cos
from hazbot_gym.core.jit import kernel
from hazbot_gym.core.state import Floats


@given(st.floats(-1e5, 1e5))
def test_sine_and_cosine_are_those_of_the_c_library(angle: float) -> None:
    assert sin_cos(angle) == pytest.approx((math.sin(angle), math.cos(angle)), abs=4e-16)


@pytest.mark.parametrize("eighths", range(-16, 17))
def test_every_octant_ends_where_the_next_begins(eighths: int) -> None:
    angle = eighths * math.pi / 4.0
    for x in (angle, math.nextafter(angle, -math.inf), math.nextafter(angle, math.inf)):
        assert sin_cos(x) == pytest.approx((math.sin(x), math.cos(x)), abs=4e-16)


@pytest.mark.parametrize("angle", [1e18, -1e300])
def test_angles_beyond_all_sense_still_give_bounded_values(angle: float) -> None:
    assert all(abs(value) <= 1.0 for value in sin_cos(angle))


@given(st.floats(DEEPEST, 0.0))
def test_decay_is_the_exponential(exponent: float) -> None:
    assert decay(exponent) == pytest.approx(math.exp(exponent), rel=2e-13)


def test_decay_is_held_to_its_range() -> None:
    assert decay(0.0) == decay(3.0) == 1.0
    assert decay(-1e9) == decay(DEEPEST) < 1e-27


@kernel
def compiled(values: Floats, out: Floats) -> None:
    for i in range(values.shape[0]):
        out[i, 0], out[i, 1] = sin_cos(values[i])
        out[i, 2] = decay(-abs(values[i]))


def test_compiled_code_gives_the_same_bits_as_python() -> None:
    values = np.random.default_rng(0).uniform(-60.0, 60.0, 1001)
    out = np.empty((len(values), 3))

    compiled(values, out)

    expected = [[*sin_cos(x), decay(-abs(x))] for x in values.tolist()]
    assert out.tolist() == np.array(expected).tolist()
