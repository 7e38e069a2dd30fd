from __future__ import annotations

import itertools

import numpy as np
import pytest

from hazbot_gym.core.proxemics import (
    INTIMATE_M,
    PERSONAL_M,
    PHASE_BOUNDS_M,
    SOCIAL_M,
    intrusion_depth,
)

METRES_PER_FOOT = 0.3048


def test_phases_end_where_hall_says() -> None:
    halls = np.array([0.5, 1.5, 2.5, 4.0, 7.0, 12.0, 25.0]) * METRES_PER_FOOT

    assert pytest.approx(halls, rel=0.02) == list(PHASE_BOUNDS_M)
    assert {INTIMATE_M, PERSONAL_M, SOCIAL_M} <= set(PHASE_BOUNDS_M)


@pytest.mark.parametrize(
    ("clearance_m", "expected"),
    [(-0.1, 1.0), (0.0, 1.0), (0.45, 1.0), (0.825, 0.5), (1.2, 0.0), (9.0, 0.0)],
)
def test_intrusion_grows_from_the_edge_of_personal_to_that_of_intimate_space(
    clearance_m: float, expected: float
) -> None:
    assert intrusion_depth(clearance_m) == pytest.approx(expected)


def test_intrusion_never_grows_with_the_clearance() -> None:
    depths = [intrusion_depth(clearance_m) for clearance_m in np.linspace(-0.5, 2.0, 251)]

    assert all(near >= far for near, far in itertools.pairwise(depths))
    assert len({round(depth, 6) for depth in depths}) > 70, "it grades instead of switching"
