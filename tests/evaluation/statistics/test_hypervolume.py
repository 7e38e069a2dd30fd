from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hazbot_gym.evaluation.statistics.crossed_bootstrap import CrossedDraws, crossed_draws
from hazbot_gym.evaluation.statistics.hypervolume import (
    Point,
    front_hypervolume,
    hypervolume,
    hypervolume_difference,
    pareto_set,
)

Points = list[tuple[int, int]]
POINTS = st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=8)
REFERENCE = (7, 6)


def test_hypervolume_by_hand() -> None:
    assert hypervolume([(1.0, 1.0)], (3.0, 4.0)) == pytest.approx(2 * 3)
    # A staircase: 1 x 1 under the first point, then 1 x 2 under the second.
    assert hypervolume([(2.0, 1.0), (1.0, 2.0)], (3.0, 3.0)) == pytest.approx(1 + 2)
    assert hypervolume([(5.0, 0.0), (0.0, 5.0)], (3.0, 3.0)) == 0.0


@given(POINTS)
def test_hypervolume_is_the_number_of_dominated_cells(points: Points) -> None:
    p = np.array(points)
    cells = np.stack(np.mgrid[: REFERENCE[0], : REFERENCE[1]], axis=-1).reshape(-1, 2)
    dominated = (p[:, None] <= cells[None]).all(axis=-1).any(axis=0)
    assert hypervolume(p, REFERENCE) == dominated.sum()


def test_hypervolume_is_the_share_of_darts_that_hit_it() -> None:
    rng = np.random.default_rng(0)
    points, darts = rng.random((6, 2)), rng.random((40_000, 2))
    hits = (points[:, None] <= darts[None]).all(axis=-1).any(axis=0)
    assert hypervolume(points, (1.0, 1.0)) == pytest.approx(hits.mean(), abs=0.01)


@given(POINTS, st.tuples(st.integers(0, 9), st.integers(0, 9)))
def test_one_more_point_never_takes_anything_away(points: Points, more: tuple[int, int]) -> None:
    assert hypervolume([*points, more], REFERENCE) >= hypervolume(points, REFERENCE)


@given(POINTS, st.integers(1, 5), st.integers(1, 5))
def test_units_of_the_axes_multiply(points: Points, x: int, y: int) -> None:
    scale = np.array([x, y])
    scaled = hypervolume(np.array(points) * scale, np.array(REFERENCE) * scale)
    assert scaled == x * y * hypervolume(points, REFERENCE)


@given(POINTS)
def test_only_the_pareto_set_counts_and_in_any_order(points: Points) -> None:
    front = np.array(points)[pareto_set(points)]
    assert hypervolume(front[::-1], REFERENCE) == hypervolume(points, REFERENCE)


@given(POINTS)
def test_everybody_outside_the_pareto_set_is_dominated_from_within(points: Points) -> None:
    inside = pareto_set(points)
    front = np.array(points)[inside]
    for point, is_in in zip(points, inside, strict=True):
        better = ((front <= point).all(axis=1) & (front < point).any(axis=1)).any()
        assert better != is_in


def test_equal_points_do_not_dominate_each_other() -> None:
    assert pareto_set([(1, 2), (1, 2), (2, 1), (2, 2)]).tolist() == [True, True, True, False]


def test_fronts_of_many_resamples_are_measured_at_once() -> None:
    points = np.random.default_rng(1).random((4, 3, 5, 2))
    volumes = hypervolume(points, (1.0, 1.0))
    assert volumes.shape == (4, 3)
    assert volumes[2, 1] == hypervolume(points[2, 1], (1.0, 1.0))


# --- fronts of policies --------------------------------------------------------------------------


def draw_two(ours: int, theirs: int, scenarios: int) -> list[CrossedDraws]:
    return crossed_draws(
        np.zeros(scenarios), [ours, theirs], np.random.default_rng(0), resamples=300
    )


def test_scores_without_variance_give_the_hypervolume_itself() -> None:
    draws, _ = draw_two(2, 2, 10)
    front = [
        Point(np.full((2, 10), x), np.full((2, 10), y), draws) for x, y in ((1.0, 2.0), (2.0, 1.0))
    ]
    assert front_hypervolume(front, (3.0, 3.0)) == pytest.approx((3.0, 3.0, 3.0))


def test_interval_of_a_single_point_is_that_of_its_mean() -> None:
    """With one axis fixed the area is a mean, whose textbook interval is known."""
    draws, _ = draw_two(1, 1, 500)
    time = np.random.default_rng(3).normal(1.0, 0.2, size=500)
    value, low, high = front_hypervolume([Point(time, np.ones(500), draws)], (3.0, 2.0))
    assert value == pytest.approx(3.0 - time.mean())
    assert (high - low) / 2 == pytest.approx(1.96 * time.std() / np.sqrt(500), rel=0.15)


def test_fronts_in_the_same_scenarios_differ_more_surely_than_apart() -> None:
    our_draws, their_draws = draw_two(3, 1, 50)
    difficulty = np.random.default_rng(4).normal(0.0, 0.3, size=(1, 50))
    seeds = np.zeros((3, 1))  # all seeds are alike
    ours = [Point(k + difficulty + seeds, 4 - k + difficulty + seeds, our_draws) for k in (1, 2, 3)]
    theirs = [Point(k + 0.2 + difficulty, 4.2 - k + difficulty, their_draws) for k in (1, 2, 3)]
    value, low, high = hypervolume_difference(ours, theirs, (5.0, 5.0))
    apart = [front_hypervolume(front, (5.0, 5.0)) for front in (ours, theirs)]
    assert value == pytest.approx(apart[0].mean - apart[1].mean)
    assert 0.0 < low <= value <= high
    assert high - low < 0.5 * (apart[0].high - apart[0].low)
    assert hypervolume_difference(ours, ours, (5.0, 5.0)) == (0.0, 0.0, 0.0)
