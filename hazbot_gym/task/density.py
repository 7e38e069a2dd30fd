"""Fundamental diagram of a corridor: walking speed over density.

As in the measurement of Zhang et al. 2011: people inside an area across the whole width of the
corridor are counted every half second, and their mean speed is assigned to their number per m^2.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.tracks import Recording, resample

AREA_LENGTH_M = 2.0  # along the corridor, at its middle
EVERY_S = 0.5
HALF_SPAN_S = 0.5  # speeds are central differences over half a second to either side
BIN_EDGES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5)  # [1/m^2]
FEWEST_SAMPLES = 5  # minimum number of moments of a bin


class Bin(NamedTuple):
    """Density bin: the moments with a density between two edges."""

    low: float  # [1/m^2]
    high: float
    samples: int
    density: float  # mean [1/m^2]
    speed_mps: float  # mean over moments of the mean speed inside
    speed_sd_mps: float


def densities_and_speeds(recording: Recording) -> Floats:
    """Return density [1/m^2] and mean speed [m/s] at every moment with people inside, (n, 2).

    Raises:
        InvalidInput: the recording is not of a corridor.
    """
    if recording.corridor is None:
        raise InvalidInput(f"tracks: {recording.name} is not of a corridor, so it has no density")
    along = 0 if recording.corridor.axis == "x" else 1
    spans = (recording.corridor.x_m, recording.corridor.y_m)
    (begin, end), (left, right) = spans[along], spans[1 - along]
    middle, area = (begin + end) / 2.0, AREA_LENGTH_M * (right - left)
    moments, speeds = _inside(recording, along, middle)
    order = np.argsort(moments, kind="stable")
    together = np.split(speeds[order], np.flatnonzero(np.diff(moments[order])) + 1)
    rows = [(len(each) / area, each.mean()) for each in together if len(each)]
    return np.array(rows).reshape(-1, 2)


def _inside(recording: Recording, along: int, middle: float) -> tuple[Ints, Floats]:
    """Return moments and speeds of people inside the area, person by person."""
    sampled = resample(recording, HALF_SPAN_S)
    latest = round(recording.duration_s / HALF_SPAN_S) - 2
    moments, speeds = [np.zeros(0, np.int64)], [np.zeros(0)]
    for first, track in zip(sampled.first_steps, sampled.tracks(), strict=True):
        moment = first + np.arange(1, len(track) - 1)
        is_inside = np.abs(track[1:-1, along] - middle) <= AREA_LENGTH_M / 2.0
        is_inside &= moment <= latest
        speed = np.hypot(*(track[2:] - track[:-2]).T) / (2.0 * HALF_SPAN_S)
        moments.append(moment[is_inside])
        speeds.append(speed[is_inside])
    return np.concatenate(moments), np.concatenate(speeds)


def fundamental_diagram(recording: Recording) -> list[Bin]:
    """Return the mean speed at each density up to 1.5 per m^2, for bins with enough data."""
    density, speed = densities_and_speeds(recording).T
    bins = []
    for low, high in itertools.pairwise(BIN_EDGES):
        there = (density >= low) & (density < high)
        if there.sum() >= FEWEST_SAMPLES:
            mean, sd = float(speed[there].mean()), float(speed[there].std())
            bins.append(Bin(low, high, int(there.sum()), float(density[there].mean()), mean, sd))
    return bins
