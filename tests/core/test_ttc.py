from __future__ import annotations

import math

import numpy as np
import pytest

from hazbot_gym.core.ttc import time_to_collision


def test_head_on_it_is_the_gap_over_the_closing_speed() -> None:
    assert time_to_collision(3.0, 0.0, -1.25, 0.0, 0.5) == pytest.approx(2.0)


def test_oblique_approach_meets_where_the_discs_touch_and_not_where_the_centres_do() -> None:
    # At an offset of 0.3 m discs of 0.5 m together touch 0.4 m before they are abreast.
    assert time_to_collision(2.4, 0.3, -1.0, 0.0, 0.5) == pytest.approx(2.0)


def test_who_passes_beside_is_never_met_however_fast_the_distance_shrinks() -> None:
    assert time_to_collision(3.0, 0.6, -1.5, 0.0, 0.5) == math.inf


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
def test_who_stands_or_leaves_is_never_met(velocity: tuple[float, float]) -> None:
    assert time_to_collision(2.0, 0.0, *velocity, 0.5) == math.inf


def test_who_touches_is_met_now_even_in_leaving() -> None:
    assert time_to_collision(0.3, 0.0, 1.0, 0.0, 0.5) == 0.0


@pytest.mark.parametrize("shape", [(), (3,), (2, 5)])
def test_shapes_are_kept(shape: tuple[int, ...]) -> None:
    assert time_to_collision(np.full(shape, 2.0), 0.0, -1.0, 0.0, 0.5).shape == shape


def test_first_touch_is_that_of_small_steps_in_time() -> None:
    rng = np.random.default_rng(3)
    p, w = rng.uniform(-3, 3, (2, 300)), rng.uniform(-2, 2, (2, 300))
    times = np.arange(0.0, 20.0, 1e-3)[:, None]
    touches = np.hypot(p[0] + w[0] * times, p[1] + w[1] * times) <= 0.5
    stepped = np.where(touches.any(axis=0), times[touches.argmax(axis=0), 0], np.inf)

    exact = time_to_collision(*p, *w, 0.5)

    met = np.isfinite(stepped)
    assert met.sum() > 20
    assert exact[met] == pytest.approx(stepped[met], abs=1.1e-3)
    # What the steps miss is a touch between two of them, or after their end.
    assert np.isinf(exact[~met]).mean() > 0.99
