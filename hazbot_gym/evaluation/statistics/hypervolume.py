"""Hypervolume of a family of policies on two axes, both to be minimized.

A policy trades delay against discomfort, so a family is a front: a policy for every value of its
parameter. Its hypervolume (Zitzler and Thiele 1998) is the area between the front and a reference
point that is worse than all. Independent noise of the points biases a front outwards, increasingly
with more points; compare families of equal size, in the same scenarios.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation.statistics.crossed_bootstrap import CrossedDraws, crossed_mean, each_once
from hazbot_gym.evaluation.statistics.intervals import Estimate
from hazbot_gym.evaluation.statistics.student import student_interval


class Point(NamedTuple):
    """A policy of a family: its scores on the two axes.

    Attributes:
        delay: (R, N) of R seeds in N scenarios.
        discomfort: (R, N) likewise.
        draws: of these seeds, and of the scenarios, which all points of all fronts share.
    """

    delay: npt.ArrayLike
    discomfort: npt.ArrayLike
    draws: CrossedDraws


Front = Sequence[Point]


def pareto_set(points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return True for each Pareto-optimal point of (K, 2), both axes minimized."""
    p = np.asarray(points, dtype=float)
    no_worse = (p[:, None] <= p[None]).all(axis=-1)
    better = (p[:, None] < p[None]).any(axis=-1)
    dominated: npt.NDArray[np.bool_] = np.any(no_worse & better, axis=0)
    return ~dominated


def hypervolume(points: npt.ArrayLike, reference: npt.ArrayLike) -> Floats:
    """Return the area dominated by points up to a reference point.

    With points sorted by x, ``sum_k (x_(k+1) - x_k) (y_ref - min_(j <= k) y_j)``, x_(K+1) = x_ref.

    Args:
        points: (..., K, 2); points beyond the reference point add nothing.
        reference: (2,).

    Returns:
        (...,) in the product of the two axes' units.
    """
    inside = np.minimum(np.asarray(points, dtype=float), reference)
    x_ref, y_ref = np.asarray(reference, dtype=float)
    order = np.argsort(inside[..., 0], axis=-1)
    x, y = (np.take_along_axis(inside[..., axis], order, axis=-1) for axis in (0, 1))
    widths = np.diff(x, axis=-1, append=x_ref)
    area: Floats = (widths * (y_ref - np.minimum.accumulate(y, axis=-1))).sum(axis=-1)
    return area


def front_hypervolume(
    front: Front, reference: npt.ArrayLike, *, confidence: float = 0.95
) -> Estimate:
    """Estimate the hypervolume of a front's mean scores with its crossed interval."""
    return student_interval(
        _of_data(front, reference), _of_resamples(front, reference), _seeds(front),
        confidence=confidence,
    )  # fmt: skip


def hypervolume_difference(
    ours: Front, theirs: Front, reference: npt.ArrayLike, *, confidence: float = 0.95
) -> Estimate:
    """Estimate the difference of two hypervolumes, paired if both share their scenario draws."""
    return student_interval(
        _of_data(ours, reference) - _of_data(theirs, reference),
        _of_resamples(ours, reference) - _of_resamples(theirs, reference),
        _seeds([*ours, *theirs]),
        confidence=confidence,
    )


def _seeds(front: Front) -> list[Floats]:
    """Return the counts of seeds of each policy, once each."""
    return list({id(point.draws.seeds): point.draws.seeds for point in front}.values())


def _of_data(front: Front, reference: npt.ArrayLike) -> float:
    once = [point._replace(draws=each_once(point.draws)) for point in front]
    return float(_of_resamples(once, reference)[0])


def _of_resamples(front: Front, reference: npt.ArrayLike) -> Floats:
    """Return the hypervolume of each resample, (B,)."""
    means = [
        [crossed_mean(scores, point.draws) for scores in (point.delay, point.discomfort)]
        for point in front
    ]
    return hypervolume(np.moveaxis(np.array(means), 2, 0), reference)
