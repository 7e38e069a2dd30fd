"""Counts of walking patterns in a recording, with every person in turn as the robot.

An event is a period, with gaps of at most 1 s, in which another person is within 3.6 m, the outer
bound of Hall's social zone. Its pattern (``core.patterns``) is the first one of its samples; events
without a pattern are not counted. Samples are taken every 0.4 s and velocities are central
differences over 0.5 s to either side, both rounded to whole steps of the recording, so that no
sample falls into the first and last half second of a track. Most pairs of people count twice.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.jit import kernel, scalar
from hazbot_gym.core.patterns import Thresholds, classify_walking
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.core.state import NO_PATTERN, PATTERN_NAMES, Floats, Ints, Records, as_record
from hazbot_gym.task.tracks import Recording

SAMPLE_S = 0.4
HALF_SPAN_S = 0.5
LONGEST_BREAK_S = 1.0

EVENT_PATTERNS = (*PATTERN_NAMES, "beside")  # by pattern code


class Samples(NamedTuple):
    """States of all people at common times.

    Attributes:
        step_s: Time between two samples [s].
        firsts: (P,) number of each person's first sample; sample 0 is at time zero.
        counts: (P,) number of each person's samples.
        states: (M, 4) x, y, vx, vy of all people, one after the other [m, m/s].
    """

    step_s: float
    firsts: Ints
    counts: Ints
    states: Floats


class PatternCount(NamedTuple):
    """Counts of one pattern; distances are NaN without events."""

    events: int
    pairs: int  # distinct pairs, in either role
    samples: int  # with this pattern, in any event
    entry_m: float  # distance at an event's labelling sample, median [m]
    closest_m: tuple[float, float, float]  # smallest sampled distance of an event, p5, p50, p95 [m]


def sample(recording: Recording) -> Samples:
    """Return all people's positions and velocities every 0.4 s."""
    every = max(1, round(SAMPLE_S / recording.dt_s))
    half = max(1, round(HALF_SPAN_S / recording.dt_s))
    firsts = np.zeros(recording.people, dtype=np.int64)
    states = []
    for i, (start, track) in enumerate(zip(recording.first_steps, recording.tracks(), strict=True)):
        firsts[i] = -(-(start + half) // every)
        at = np.arange(firsts[i] * every - start, len(track) - half, every)
        velocities = (track[at + half] - track[at - half]) / (2 * half * recording.dt_s)
        states.append(np.concatenate([track[at], velocities], axis=1))
    counts = np.array([len(state) for state in states])
    return Samples(every * recording.dt_s, firsts, counts, np.concatenate(states))


def pattern_events(
    recording: Recording, thresholds: Thresholds | None = None
) -> dict[str, PatternCount]:
    """Return the counts of each pattern in a recording."""
    samples = sample(recording)
    break_steps = int(LONGEST_BREAK_S / samples.step_s + 1e-9)
    rows, by_pattern = _events(
        samples.firsts,
        samples.counts,
        samples.states,
        break_steps,
        as_record(thresholds or Thresholds()),
    )
    events = np.array(rows, dtype=np.float64).reshape(-1, 5)
    return {
        name: _count(events[events[:, 2] == code], int(by_pattern[code]))
        for code, name in enumerate(EVENT_PATTERNS)
    }


def _count(events: Floats, samples: int) -> PatternCount:
    """Summarise the events (n, 5) of one pattern."""
    if not len(events):
        return PatternCount(0, 0, samples, np.nan, (np.nan, np.nan, np.nan))
    pairs = np.unique(np.sort(events[:, :2], axis=1), axis=0)
    p5, p50, p95 = (float(value) for value in np.percentile(events[:, 4], [5, 50, 95]))
    return PatternCount(
        len(events), len(pairs), samples, float(np.median(events[:, 3])), (p5, p50, p95)
    )


@kernel
def _events(
    firsts: Ints, counts: Ints, states: Floats, break_steps: int, thresholds: Records
) -> tuple[list[tuple[int, int, int, float, float]], Ints]:
    """Return events (robot, person, pattern, entry, closest) and the samples per pattern."""
    offsets = np.cumsum(counts) - counts
    rows = [(0, 0, 0, 0.0, 0.0) for _ in range(0)]
    samples = np.zeros(len(EVENT_PATTERNS), np.int64)
    for r in range(len(firsts)):
        for p in range(len(firsts)):
            begin = max(firsts[r], firsts[p])
            end = min(firsts[r] + counts[r], firsts[p] + counts[p])
            if r == p or begin >= end:
                continue
            robot = states[offsets[r] + begin - firsts[r] : offsets[r] + end - firsts[r]]
            person = states[offsets[p] + begin - firsts[p] : offsets[p] + end - firsts[p]]
            for event in pair_events(robot, person, break_steps, thresholds[0], samples):
                rows.append((r, p, event[0], event[1], event[2]))
    return rows, samples


@scalar
def pair_events(
    robot: Floats, person: Floats, break_steps: int, thresholds: Thresholds, samples: Ints
) -> list[tuple[int, float, float]]:
    """Return the events (pattern, entry and closest distance) of two people's common states (n, 4).

    Adds the samples of each pattern to ``samples``.
    """
    events = [(0, 0.0, 0.0) for _ in range(0)]
    code, entry, closest, last = NO_PATTERN, 0.0, np.inf, -1
    for k in range(len(robot)):
        px, py, _, _ = person[k] - robot[k]
        distance = math.hypot(px, py)
        if distance > SOCIAL_M:
            continue
        if k - last > break_steps:
            if code != NO_PATTERN:
                events.append((code, entry, closest))
            code, closest = NO_PATTERN, np.inf
        last = k
        closest = min(closest, distance)
        _, _, vx, vy = robot[k]
        label = classify_walking(
            px, py, math.atan2(vy, vx), math.hypot(vx, vy), person[k, 2], person[k, 3], thresholds
        )
        if label != NO_PATTERN:
            samples[label] += 1
            if code == NO_PATTERN:
                code, entry = label, distance
    if code != NO_PATTERN:
        events.append((code, entry, closest))
    return events
