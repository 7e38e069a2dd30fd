"""Ratings of a robot's place among people, read from two tables.

``ratings.csv`` has the columns ``sample, rater, score, humans``: a rater scores the place of a
standing robot in a sample of people from 0 (unacceptable) to 100 (perfect). ``humans.csv`` has
``sample, human, x_m, y_m, yaw_deg``: the people of each sample, with the robot at the origin.

The format is that of SocNav1 (Manso, Nuñez, Calderita, Faria and Bachiller 2020, Data 5(1):7,
https://doi.org/10.3390/data5010007), whose yaw is 90 degrees ahead of the facing direction: with
this offset, people who interact face each other exactly.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput

RATINGS, HUMANS = "ratings.csv", "humans.csv"
SCORES = (0.0, 100.0)
YAW_OFFSET_RAD = math.pi / 2  # of the yaw to the facing direction


class Ratings(NamedTuple):
    """S ratings with up to P people each, the nearest first."""

    discomfort: Floats  # (S,) 1 - score / 100
    raters: npt.NDArray[np.str_]  # (S,)
    people: Ints  # (S,) number of people
    distance_m: Floats  # (S, P) between centers of robot and person, infinite if absent
    facing: Floats  # (S, P) cosine of the robot's bearing as seen by the person: 1 if it faces it

    def where(self, chosen: npt.NDArray[np.generic]) -> Ratings:
        """Return the ratings of a mask or an index array."""
        return Ratings(*(column[chosen] for column in self))


def load_ratings(folder: Path) -> Ratings:
    """Return the ratings of a folder.

    Raises:
        InvalidInput: A table is missing, lacks a column, or has a value that cannot be used.
    """
    rows = list(_rows(folder / RATINGS, ("sample", "rater", "score")))
    if not rows:
        raise InvalidInput(f"ratings: {str(folder / RATINGS)!r} has no rows")
    samples = {row["sample"]: i for i, row in enumerate(rows)}
    if len(samples) < len(rows):
        raise InvalidInput(f"ratings: {str(folder / RATINGS)!r} rates a sample twice")
    people: list[list[tuple[float, float]]] = [[] for _ in rows]
    for number, row in enumerate(_rows(folder / HUMANS, ("sample", "x_m", "y_m", "yaw_deg")), 2):
        if row["sample"] not in samples:
            raise InvalidInput(
                f"ratings: {str(folder / HUMANS)!r}, line {number}: sample {row['sample']!r} is "
                f"not in {RATINGS}"
            )
        people[samples[row["sample"]]].append(_seen(row, folder / HUMANS, number))
    distance_m = np.full((len(rows), max(1, *map(len, people))), np.inf)
    facing = np.zeros_like(distance_m)
    for i, each in enumerate(people):
        if each:
            distance_m[i, : len(each)], facing[i, : len(each)] = zip(*sorted(each), strict=True)
    scores = [
        _number(row, "score", folder / RATINGS, number, *SCORES)
        for number, row in enumerate(rows, 2)
    ]
    return Ratings(
        discomfort=1.0 - np.array(scores) / SCORES[1],
        raters=np.array([row["rater"] for row in rows]),
        people=np.array([len(each) for each in people]),
        distance_m=distance_m,
        facing=facing,
    )


def _seen(row: Mapping[str, str], path: Path, line: int) -> tuple[float, float]:
    """Return a person's distance to the robot, and the cosine of the robot's bearing."""
    x, y = (_number(row, name, path, line) for name in ("x_m", "y_m"))
    facing = math.radians(_number(row, "yaw_deg", path, line)) - YAW_OFFSET_RAD
    return math.hypot(x, y), math.cos(facing - math.atan2(-y, -x))


def _rows(path: Path, columns: tuple[str, ...]) -> Iterator[dict[str, str]]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            missing = [name for name in columns if name not in (reader.fieldnames or ())]
            if missing:
                raise InvalidInput(f"ratings: {str(path)!r} lacks the column {missing[0]!r}")
            yield from reader
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidInput(f"ratings: {str(path)!r} cannot be read: {error}") from error


def _number(
    row: Mapping[str, str], name: str, path: Path, line: int,
    low: float = -math.inf, high: float = math.inf,
) -> float:  # fmt: skip
    """Return a finite number of a row, within bounds."""
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        value = math.nan
    if not (math.isfinite(value) and low <= value <= high):
        allowed = f"{low:g} to {high:g}" if math.isfinite(low) else "a finite number"
        raise InvalidInput(
            f"ratings: {str(path)!r}, line {line}: {name} is {row[name]!r}, allowed is {allowed}"
        )
    return value
