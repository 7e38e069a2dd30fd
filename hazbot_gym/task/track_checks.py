"""Plausibility checks of a recording's unit, rate and columns."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.task.tracks import Recording

GUESS = "guess: people walk"  # source of a unit that neither file nor user states
WALKING_MPS = (0.3, 2.2)  # medians outside are improbable
STILL_MPS = 0.05  # below, people do not walk
SMALLEST_EXTENT_M = 1.0
MOST_PIECES = 2.0  # tracks of one id, on average
FEWEST_SIGHTINGS = 3.0  # of one id, on average
_STANDING_MPS = 0.2  # slower samples are excluded from the median, if enough others remain
_FEWEST_WALKING = 0.05
_SPAN_S = 1.0  # time base of speeds, which averages out the body's sway


def walking_speed(ids: Ints, frames: Ints, positions: Floats, fps: float) -> Floats:
    """Return speeds (n,) of people over about a second, in units of the positions per second."""
    same = np.diff(ids) == 0
    gaps = np.diff(frames)[same]
    rows = max(1, round(_SPAN_S * fps / float(np.median(gaps)))) if len(gaps) else 1
    for span in (rows, 1):
        is_one = ids[span:] == ids[:-span]
        if is_one.any():
            steps = np.hypot(*(positions[span:] - positions[:-span])[is_one].T)
            return np.asarray(steps * fps / (frames[span:] - frames[:-span])[is_one])
    return np.zeros(0)


def median_speed(speeds_mps: Floats) -> float:
    """Return the median speed of walking samples, or of all if few walk [m/s]."""
    walking = speeds_mps[speeds_mps > _STANDING_MPS]
    is_enough = len(walking) > _FEWEST_WALKING * len(speeds_mps)
    return float(np.median(walking if is_enough else speeds_mps))


def doubts(recording: Recording) -> list[str]:
    """Return one sentence per failed plausibility check."""
    reading = recording.reading
    found = list(reading.notes) if reading else []
    low, high = WALKING_MPS
    speed = reading.speed_mps if reading else low
    if reading and reading.unit_from == GUESS and reading.unit != "m":
        found.append(
            f"its unit is not given; {reading.unit} is a guess, in which people walk at "
            f"{speed:.2f} m/s: give units"
        )
    if not low <= speed <= high:
        found.append(
            f"people walk at {speed:.2f} m/s in the median, improbable outside {low} to {high}: "
            "are fps and units right?"
        )
    extent = float(np.ptp(recording.positions, axis=0).max())
    if extent < SMALLEST_EXTENT_M:
        found.append(f"everything is within {extent:.2f} m: are units right?")
    ids = len(np.unique(recording.ids))
    if recording.people > MOST_PIECES * ids:
        found.append(
            f"{ids} ids are seen as {recording.people} people, as gaps are longer than 0.5 s: "
            "is fps right?"
        )
    sightings = len(recording.positions) / ids
    if sightings < FEWEST_SIGHTINGS:
        found.append(f"an id is seen {sightings:.1f} times on average: are id and frame swapped?")
    return found
