from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.calibration.discomfort import RADII_M, Curve, nearness
from hazbot_gym.core.discomfort import CONTACT_M, DIRECTION, LENGTH_M, discomfort, facing
from hazbot_gym.utils.files import read_json

RECORD = Path(__file__).parents[2] / "benchmarks" / "discomfort.json"


def test_constants_are_those_of_the_record() -> None:
    curve = read_json(RECORD)["curve"]
    rounded = [float(f"{curve[name]:.3g}") for name in ("contact_m", "length_m", "direction")]
    assert rounded == [CONTACT_M, LENGTH_M, DIRECTION]


@given(st.floats(-0.6, 8.0), st.floats(-1.0, 1.0))
def test_it_is_the_curve_of_the_ratings(clearance_m: float, toward: float) -> None:
    curve = Curve(0.0, CONTACT_M, LENGTH_M, DIRECTION)
    rated = nearness(curve, np.array([clearance_m + RADII_M]), np.array([toward]))[0]
    assert discomfort(clearance_m, toward) == pytest.approx(rated)


def test_it_falls_smoothly_with_the_clearance() -> None:
    values = [discomfort(0.01 * k, 0.0) for k in range(400)]
    drops = [a - b for a, b in itertools.pairwise(values)]
    assert min(drops) > 0.0
    assert max(drops) < 0.02


@pytest.mark.parametrize(
    ("vx", "vy", "expected"),
    [(-1.2, 0.0, -1.0), (1.2, 0.0, 1.0), (0.0, 1.2, 0.0), (0.0, 0.0, 0.0), (0.15, 0.0, 0.5)],
)
def test_person_faces_its_walking_direction(vx: float, vy: float, expected: float) -> None:
    assert facing(2.0, 0.0, vx, vy) == pytest.approx(expected)


@given(*[st.floats(-5.0, 5.0)] * 4)
def test_facing_is_a_cosine(x: float, y: float, vx: float, vy: float) -> None:
    assert abs(facing(x, y, vx, vy)) <= 1.0 + 1e-12
