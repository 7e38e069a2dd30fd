"""Statistics of a recording, and the entries of its people.

Speeds are those of ``pattern_events.sample``: over half a second to either side, which averages the
sway of the body out. Distances are between centres, at every step of the recording.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.jit import kernel
from hazbot_gym.core.patterns import Thresholds
from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.task.pattern_events import PatternCount, Samples, pattern_events, sample
from hazbot_gym.task.tracks import Recording

STANDING_MPS = 0.2  # a slower sample counts as standing
IMPOSSIBLE_MPS = 5.0  # a step faster than this is an error of the tracking
SHORTEST_STAY_S, SHORTEST_WALK_M = 1.0, 1.0  # minimum duration and distance of an entry
PERCENTILES = (5, 25, 50, 75, 95)


class Statistics(NamedTuple):
    """Statistics of a recording; NaN if undefined."""

    people: int
    duration_s: float
    people_in_view_median: float
    people_in_view_max: int
    person_speed_mps: float  # median over people of each one's median speed
    person_speed_sd_mps: float
    speed_percentiles_mps: tuple[float, ...]  # of all samples: 5, 25, 50, 75, 95 %
    standing_share: float  # of all samples
    nearest_mean_m: float  # distance to the nearest other person, over all sightings
    nearest_p5_m: float
    nearest_min_m: float
    impossible_steps: int  # faster than 5 m/s
    patterns: dict[str, PatternCount]


class Entries(NamedTuple):
    """Entries of people, one row per person in order of entry.

    Attributes:
        times_s: (n,) time of entry [s].
        entry_points: (n, 2) first position [m].
        exit_points: (n, 2) last position [m].
        speeds_mps: (n,) median speed while walking [m/s].
    """

    times_s: Floats
    entry_points: Floats
    exit_points: Floats
    speeds_mps: Floats


def statistics(recording: Recording) -> Statistics:
    """Return the statistics of a recording."""
    by_person = _speeds(sample(recording))
    medians = [np.median(speeds) for speeds in by_person if len(speeds)]
    speeds = np.concatenate(by_person)
    starts, ends = recording.first_steps, recording.first_steps + recording.lengths
    in_view = np.cumsum(np.bincount(starts, minlength=ends.max()) - np.bincount(ends)[:-1])
    steps = [np.diff(track, axis=0) for track in recording.tracks()]
    lengths = np.hypot(*np.concatenate(steps).T)
    nearest = _nearest_distances(starts, recording.lengths, recording.positions)
    nearest = nearest[np.isfinite(nearest)]
    return Statistics(
        people=recording.people,
        duration_s=recording.duration_s,
        people_in_view_median=float(np.median(in_view)),
        people_in_view_max=int(in_view.max()),
        person_speed_mps=float(np.median(medians)) if medians else math.nan,
        person_speed_sd_mps=float(np.std(medians)) if medians else math.nan,
        speed_percentiles_mps=tuple(_percentile(speeds, q) for q in PERCENTILES),
        standing_share=float(np.mean(speeds <= STANDING_MPS)) if len(speeds) else math.nan,
        nearest_mean_m=float(nearest.mean()) if len(nearest) else math.nan,
        nearest_p5_m=_percentile(nearest, 5),
        nearest_min_m=_percentile(nearest, 0),
        impossible_steps=int(np.sum(lengths > IMPOSSIBLE_MPS * recording.dt_s)),
        patterns=pattern_events(recording),
    )


def entries(recording: Recording) -> Entries:
    """Return the entries of people seen for at least 1 s and walking at least 1 m.

    A speed is the median over moving samples, so that stops do not count.
    """
    rows = []
    speeds = _speeds(sample(recording))
    for first, track, all_speeds in zip(
        recording.first_steps, recording.tracks(), speeds, strict=True
    ):
        stay_s = (len(track) - 1) * recording.dt_s
        walking = all_speeds[all_speeds > Thresholds().moving_mps]
        reach = np.hypot(*(track - track[0]).T).max()
        if stay_s >= SHORTEST_STAY_S and reach >= SHORTEST_WALK_M and len(walking):
            rows.append((first * recording.dt_s, *track[0], *track[-1], np.median(walking)))
    table = np.array(sorted(rows), dtype=np.float64).reshape(-1, 6)
    return Entries(table[:, 0], table[:, 1:3], table[:, 3:5], table[:, 5])


def _speeds(samples: Samples) -> list[Floats]:
    speeds = np.hypot(samples.states[:, 2], samples.states[:, 3])
    return np.split(speeds, np.cumsum(samples.counts)[:-1])


def _percentile(values: Floats, q: int) -> float:
    return float(np.percentile(values, q)) if len(values) else math.nan


@kernel
def _nearest_distances(firsts: Ints, lengths: Ints, positions: Floats) -> Floats:
    """Return for every sighting (N,) the distance to the nearest other person, inf if alone [m]."""
    offsets = np.cumsum(lengths) - lengths
    nearest = np.full(len(positions), np.inf)
    for i in range(len(firsts)):
        for j in range(i):
            begin = max(firsts[i], firsts[j])
            end = min(firsts[i] + lengths[i], firsts[j] + lengths[j])
            for step in range(begin, end):
                a = offsets[i] + step - firsts[i]
                b = offsets[j] + step - firsts[j]
                dx = positions[a, 0] - positions[b, 0]
                dy = positions[a, 1] - positions[b, 1]
                distance = math.hypot(dx, dy)
                nearest[a] = min(nearest[a], distance)
                nearest[b] = min(nearest[b], distance)
    return nearest
