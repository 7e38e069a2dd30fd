"""Time stamps of track files as numbers of frames."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.errors import InvalidInput

MOST_STEPS = 1e9
LARGEST_MISS = 0.25  # tolerance of time stamps, in steps
_RATES = (*range(1, 241), 2.5, 7.5, 12.5, 24e3 / 1001, 30e3 / 1001, 60e3 / 1001)  # frames a second


def frames_of(
    name: str, ids: Floats, times_s: Floats, fps: float | None = None
) -> tuple[Ints, float]:
    """Return the frame (N,) of each time stamp, and the frames per second.

    The rate is that of the smallest steps of people, refined over longer and longer spans; common
    rates are preferred where they fit as well.

    Args:
        name: of the file.
        ids: (N,) number of the person.
        times_s: (N,) time stamps [s].
        fps: Frames per second, if known.

    Raises:
        InvalidInput: the time stamps are not multiples of one step.
    """
    since_s = times_s - times_s.min()
    stamps = np.unique(since_s)
    step_s = 1.0 / fps if fps else _smallest_step(name, ids, since_s)
    if stamps[-1] > MOST_STEPS * step_s:
        raise InvalidInput(
            f"{name}: time stamps are {step_s:.3g} s apart and span {stamps[-1]:.3g} s, more than "
            f"{MOST_STEPS:.0e} steps"
        )
    if not fps:
        step_s = _common(stamps, _refined(stamps, step_s))
    miss = _miss(stamps, step_s)
    if miss > LARGEST_MISS:
        raise InvalidInput(
            f"{name}: time stamps are not multiples of one step: with {step_s:.4g} s one is "
            f"{miss:.0%} of a step off; resample them, or give fps"
        )
    return np.rint(since_s / step_s).astype(np.int64), 1.0 / step_s


def rate_of(frames: Floats, times_s: Floats) -> float | None:
    """Return the frames per second of frames with time stamps; None if they do not agree."""
    order = np.argsort(frames, kind="stable")
    frames, times_s = frames[order] - frames.min(), times_s[order] - times_s.min()
    if not frames[-1] > 0.0 or not times_s[-1] > 0.0:
        return None
    step_s = float(frames @ times_s / (frames @ frames))
    is_linear = np.abs(times_s - frames * step_s).max() <= max(0.02 * times_s[-1], step_s)
    return 1.0 / _common(np.unique(times_s), step_s) if is_linear else None


def _smallest_step(name: str, ids: Floats, since_s: Floats) -> float:
    order = np.lexsort((since_s, ids))
    steps = np.diff(since_s[order])[np.diff(ids[order]) == 0]
    steps = steps[steps > 0.0]
    if not len(steps):
        raise InvalidInput(f"{name}: no person is recorded at more than one time")
    smallest = np.percentile(steps, 5)
    return float(np.mean(steps[steps < 1.5 * smallest]))


def _refined(stamps: Floats, step_s: float) -> float:
    """Return the step that fits stamps, from the first few to all of them."""
    reach = 2.0 * step_s
    while True:
        near = stamps[stamps <= 1.01 * reach]
        counts = np.rint(near / step_s)
        if counts.any():
            step_s = float(near @ counts / (counts @ counts))
        if reach >= stamps[-1]:
            return step_s
        reach *= 2.0


def _common(stamps: Floats, step_s: float) -> float:
    """Return the step of a common rate if it fits the stamps about as well, else the step."""
    rate = min(_RATES, key=lambda each: abs(each * step_s - 1.0))
    is_near = abs(rate * step_s - 1.0) < 0.01
    return 1.0 / rate if is_near and _miss(stamps, 1.0 / rate) <= LARGEST_MISS / 2 else step_s


def _miss(stamps: Floats, step_s: float) -> float:
    return float(np.abs(stamps / step_s - np.rint(stamps / step_s)).max())
