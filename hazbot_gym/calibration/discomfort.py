"""Discomfort of a robot's nearness as a function of distance and direction, fitted to ratings.

    D(d, phi) = D_0 + (1 - D_0) min(1, exp(-(d - d_c) / (L exp(a cos phi))))

with the distance d between the centers of the robot and a person, the robot's bearing phi as seen
by this person (0 if the person faces the robot), the discomfort D_0 far from all people, the
distance d_c of full discomfort, the decay length L, and the effect a of the direction. Among
several people the largest D counts.

Every rater has the same weight. Variants with fewer and more effects are compared by predictions
for raters not fitted on; intervals are percentiles of a bootstrap over raters.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hazbot_gym.calibration.ratings import Ratings
from hazbot_gym.core.proxemics import PHASE_BOUNDS_M, SOCIAL_M
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.utils.json_object import JsonObject

try:
    from scipy.optimize import least_squares
except ImportError as error:
    raise MissingExtra("scipy", "study") from error

START = (0.05, 0.3, 0.7, 0.0, 0.0)  # of the search, in the order of ``Curve``
DRAWS, LEVEL = 500, 0.95  # of the bootstrap
BINS_M = (0.0, 0.3, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 3.6, 5.0)
GRID_M = tuple(round(0.1 * k, 1) for k in range(2, 46))  # of the plotted curve
DIRECTIONS = {"front": 1.0, "side": 0.0, "behind": -1.0}  # cosine of the robot's bearing
FEWEST_RATERS = 3
LEAST_COMFORT = 1e-6  # beside another person, for powers of it
RADII_M = ROBOT_RADIUS_M + PERSON_RADIUS_M


class Curve(NamedTuple):
    """Constants of the discomfort function."""

    floor: float  # D_0
    contact_m: float  # d_c
    length_m: float  # L
    direction: float = 0.0  # a
    others: float = 0.0  # weight of the people who are not nearest


def nearness(curve: Curve, distance_m: Floats, facing: Floats) -> Floats:
    """Return the discomfort caused by a person, without the floor, in [0, 1]; same shape."""
    length_m = curve.length_m * np.exp(curve.direction * facing)
    with np.errstate(over="ignore"):
        decayed: Floats = np.exp(-(distance_m - curve.contact_m) / length_m)
    return np.minimum(decayed, 1.0)


def of_strongest(curve: Curve, distance_m: Floats, facing: Floats) -> Floats:
    """Return the discomfort among people (S, P), the largest that a person causes: (S,)."""
    total: Floats = curve.floor + (1.0 - curve.floor) * nearness(curve, distance_m, facing).max(1)
    return total


def of_nearest(curve: Curve, distance_m: Floats, facing: Floats) -> Floats:
    """Return the discomfort among people (S, P), the nearest first: (S,).

    People who are not nearest count with the exponent ``others``: with 1 as much as the nearest,
    with 0 not at all.
    """
    comfort = 1.0 - nearness(curve, distance_m, facing)
    rest = np.prod(np.maximum(comfort[:, 1:], LEAST_COMFORT) ** curve.others, axis=1)
    total: Floats = 1.0 - (1.0 - curve.floor) * comfort[:, 0] * rest
    return total


class Variant(NamedTuple):
    """A model of the ratings with some effects."""

    name: str
    discomfort: Callable[[Curve, Floats, Floats], Floats]
    constants: int  # number of fitted constants, the first of ``Curve``


VARIANTS = (
    Variant("nearest person", of_nearest, 3),
    Variant("nearest person, with direction", of_nearest, 4),
    Variant("nearest and other people, with direction", of_nearest, 5),
    Variant("strongest person, with direction", of_strongest, 4),
)
ALL_PEOPLE, CHOSEN = VARIANTS[2:]


def fit(ratings: Ratings, variant: Variant = CHOSEN) -> Curve:
    """Return the curve of least squared error, every rater with the same weight."""
    names, rater = np.unique(ratings.raters, return_inverse=True)
    weights = 1.0 / np.sqrt(np.bincount(rater)[rater] * len(names))

    def errors(constants: Floats) -> Floats:
        model = variant.discomfort(Curve(*constants), ratings.distance_m, ratings.facing)
        return weights * (model - ratings.discomfort)

    found = least_squares(errors, START[: variant.constants])
    return Curve(*map(float, found.x))


def error_on_others(ratings: Ratings, variant: Variant) -> float:
    """Return the RMS error for raters not fitted on, one after the other."""
    squares = []
    for rater in np.unique(ratings.raters):
        test = ratings.where(ratings.raters == rater)
        curve = fit(ratings.where(ratings.raters != rater), variant)
        model = variant.discomfort(curve, test.distance_m, test.facing)
        squares.append(np.mean((model - test.discomfort) ** 2))
    return float(np.sqrt(np.mean(squares)))


def bootstrap(
    ratings: Ratings, *, draws: int, seed: int, on_progress: Callable[[], None] = lambda: None
) -> list[Curve]:
    """Return the curves of resampled raters."""
    rng, curves = np.random.default_rng(seed), []
    names = np.unique(ratings.raters)
    rows = {name: np.flatnonzero(ratings.raters == name) for name in names}
    for _ in range(draws):
        drawn = rng.choice(names, len(names))
        chosen = ratings.where(np.concatenate([rows[name] for name in drawn]))
        copies = np.concatenate([np.full(len(rows[name]), str(i)) for i, name in enumerate(drawn)])
        curves.append(fit(chosen._replace(raters=copies)))
        on_progress()
    return curves


def report(
    ratings: Ratings, *, draws: int = DRAWS, seed: int = 0,
    on_progress: Callable[[], None] = lambda: None,
) -> JsonObject:  # fmt: skip
    """Return the fit, its intervals and the compared variants, for JSON and tables.

    Raises:
        InvalidInput: Too few raters for an interval over raters.
    """
    raters = len(np.unique(ratings.raters))
    if raters < FEWEST_RATERS:
        raise InvalidInput(f"ratings: given {raters} raters, allowed are {FEWEST_RATERS} or more")
    curve = fit(ratings)
    curves = bootstrap(ratings, draws=draws, seed=seed, on_progress=on_progress)
    bounds = [bound for bound in PHASE_BOUNDS_M if bound <= SOCIAL_M]
    return {
        "ratings": len(ratings.discomfort),
        "raters": raters,
        "level": LEVEL,
        "draws": draws,
        "curve": curve._asdict(),
        "intervals": {
            name: _interval([getattr(each, name) for each in curves])
            for name in Curve._fields[: CHOSEN.constants]
        },
        "others": fit(ratings, ALL_PEOPLE).others,
        "error_on_other_raters": {
            variant.name: error_on_others(ratings, variant) for variant in VARIANTS
        },
        "bounds": [
            {"clearance_m": bound, **_at(curve, curves, bound + RADII_M)} for bound in bounds
        ],
        "grid": [{"distance_m": d, **_at(curve, curves, d)} for d in GRID_M],
        "bins": _bins(ratings),
    }


def _at(curve: Curve, curves: list[Curve], distance_m: float) -> JsonObject:
    """Return value and interval of the nearness in each direction at a distance."""
    at = np.array([distance_m])
    return {
        name: {
            "value": float(nearness(curve, at, np.array([facing]))[0]),
            "interval": _interval(
                [float(nearness(each, at, np.array([facing]))[0]) for each in curves]
            ),
        }
        for name, facing in DIRECTIONS.items()
    }


def _interval(values: list[float]) -> list[float]:
    tail = (1.0 - LEVEL) / 2.0
    return [float(value) for value in np.quantile(values, (tail, 1.0 - tail))]


def _bins(ratings: Ratings) -> list[JsonObject]:
    """Return the mean discomfort by distance and direction of the nearest person."""
    rows = []
    for low, high in itertools.pairwise(BINS_M):
        near = (ratings.distance_m[:, 0] > low) & (ratings.distance_m[:, 0] <= high)
        row: JsonObject = {"low_m": low, "high_m": high, "ratings": int(near.sum())}
        for name, facing in DIRECTIONS.items():
            toward = near & (np.abs(ratings.facing[:, 0] - facing) <= 0.5)
            row[name] = float(ratings.discomfort[toward].mean()) if toward.any() else None
        rows.append(row)
    alone = ratings.people == 0
    if alone.any():
        mean = float(ratings.discomfort[alone].mean())
        nobody = {"low_m": None, "high_m": None, "ratings": int(alone.sum())}
        rows.append(nobody | dict.fromkeys(DIRECTIONS, mean))
    return rows
