from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.noise import (
    noise_value,
    normal_pair,
    philox4x32,
    uniform4,
    uniform_noise,
)
from hazbot_gym.core.state import Floats

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "philox.json").read_text())
KEY = np.uint64(0x0123456789ABCDEF)
STEPS = 5000


@kernel
def uniforms(key: np.uint64, stream: int, index: int, out: Floats) -> None:
    for step in range(out.shape[0]):
        out[step, 0], out[step, 1], out[step, 2], out[step, 3] = uniform4(key, stream, step, index)


def draw(key: np.uint64 = KEY, stream: int = 3, index: int = 0) -> Floats:
    out = np.empty((STEPS, 4))
    uniforms(key, stream, index, out)
    return out


@pytest.mark.parametrize("answer", REFERENCE["known_answers"])
def test_generator_gives_the_published_words(answer: dict[str, list[str]]) -> None:
    counter = [np.uint64(int(word, 16)) for word in answer["counter"]]
    low, high = (int(word, 16) for word in answer["key"])

    words = philox4x32(*counter, np.uint64(low | high << 32))

    assert [f"{int(word):08x}" for word in words] == answer["words"]


def test_compiled_code_gives_the_same_numbers_as_python() -> None:
    expected = [uniform4(KEY, 3, step, 7) for step in range(100)]

    assert draw(index=7)[:100].tolist() == [list(row) for row in expected]


def test_uniform_numbers_are_uniform_and_the_four_of_a_call_independent() -> None:
    numbers = draw()
    counts = np.array([np.histogram(column, 20, (0.0, 1.0))[0] for column in numbers.T])
    chi_squared = np.sum((counts - STEPS / 20) ** 2 / (STEPS / 20), axis=1)

    assert numbers.min() > 0.0
    assert numbers.max() < 1.0
    assert chi_squared.max() < 43.8  # p = 0.001 at 19 degrees of freedom
    correlations = np.corrcoef(numbers.T)[np.triu_indices(4, 1)]
    assert np.abs(correlations).max() < 4.0 / math.sqrt(STEPS)


@pytest.mark.parametrize(
    "other",
    [{"key": KEY + np.uint64(1)}, {"key": KEY + np.uint64(1 << 32)}, {"stream": 4}, {"index": 1}],
)
def test_neighbouring_keys_streams_and_indices_are_independent(other: dict[str, int]) -> None:
    a, b = draw()[:, 0], draw(**other)[:, 0]

    assert abs(np.corrcoef(a, b)[0, 1]) < 4.0 / math.sqrt(STEPS)
    assert abs(np.corrcoef(a[1:], b[:-1])[0, 1]) < 4.0 / math.sqrt(STEPS)


def test_normal_numbers_have_the_moments_of_the_normal_distribution() -> None:
    normals = np.array([normal_pair(u1, u2) for u1, u2, *_ in draw().tolist()])

    assert normals.mean(axis=0) == pytest.approx([0.0, 0.0], abs=4.0 / math.sqrt(STEPS))
    assert np.cov(normals.T) == pytest.approx(np.eye(2), abs=6.0 / math.sqrt(STEPS))
    assert np.mean(np.abs(normals) < 1.96) == pytest.approx(0.95, abs=0.01)


def test_uniform_noise_has_no_mean_and_unit_deviation() -> None:
    noise = np.array([uniform_noise(u) for u in draw()[:, 0].tolist()])

    assert noise.mean() == pytest.approx(0.0, abs=4.0 / math.sqrt(STEPS))
    assert noise.std() == pytest.approx(1.0, abs=0.02)


def test_largest_and_smallest_uniform_numbers_give_finite_normal_ones() -> None:
    for u in (0.5 * 2.0**-32, 1.0 - 0.5 * 2.0**-32):
        assert all(math.isfinite(value) for value in normal_pair(u, u))


def test_sensor_noise_is_uniform_within_its_half_width_or_normal_with_half_of_it() -> None:
    pairs = draw()[:, :2].tolist()
    uniform = np.array([noise_value(u1, u2, 0.03, False) for u1, u2 in pairs])
    normal = np.array([noise_value(u1, u2, 0.03, True) for u1, u2 in pairs])

    assert (uniform.min(), uniform.max()) == pytest.approx((-0.03, 0.03), abs=1e-4)
    assert uniform.std() == pytest.approx(0.03 / math.sqrt(3.0), rel=0.03)
    assert normal.std() == pytest.approx(0.015, rel=0.04)
    assert abs(normal.mean()) < 0.001
