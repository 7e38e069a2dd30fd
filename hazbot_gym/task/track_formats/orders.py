"""Inference of the column order in tables without names.

Two orders of ``id`` and ``frame`` are in use. Signs of the right order: a person moves smoothly
from frame to frame, is seen in consecutive frames, and there are more frames than people; frame
numbers may have a common step (10 in 2.5 Hz sets). If the signs disagree, names are required.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput

# By the number of columns: what follows id and frame.
REST = {
    4: ("x y",),
    5: ("x y z",),
    6: ("x y vx vy",),
    8: ("x z y vx vz vy", "x y z vx vy vz"),
}
SURE = 2  # sum of signs that decides an order
_SAMPLE = 200_000  # number of inspected rows


def recognized(name: str, cells: Floats) -> str:
    """Return the names of the columns of a table (N, 4 | 5 | 6 | 8), from left to right.

    Raises:
        InvalidInput: the values fit no known order, or two equally well.
    """
    cells = cells[:_SAMPLE]
    width = cells.shape[1]
    fault = f"{name}: the order of its {width} columns cannot be told from the values"
    remedy = "; give columns, such as 'frame id x y'"
    rest = _rest(cells)
    if rest is None:
        raise InvalidInput(fault + remedy)
    words = rest.split()
    x, y = 2 + words.index("x"), 2 + words.index("y")
    sign = _sign(cells[:, 0], cells[:, 1], cells[:, [x, y]])
    if abs(sign) < SURE:
        raise InvalidInput(f"{fault}: id and frame could be either way round{remedy}")
    order = ("id frame " if sign > 0 else "frame id ") + rest
    if width == 5 and _is_clock(cells, int(sign < 0), int(sign > 0)):
        raise InvalidInput(f"{fault}: the third counts with the frames, as a time does{remedy}")
    if "vx" in words:
        v = [2 + words.index("vx"), 2 + words.index("vy")]
        _check_velocities(f"{fault}: the last are no velocities{remedy}", cells, sign, [x, y], v)
    return order


def _rest(cells: Floats) -> str | None:
    """Return the columns after id and frame: of eight columns, the constant one is the height."""
    options = REST[cells.shape[1]]
    if len(options) == 1:
        return options[0]
    third, fourth = cells[:, 3], cells[:, 4]
    if not third.any() or np.ptp(third) < 0.2 * np.ptp(fourth):
        return options[0]
    if not fourth.any() or np.ptp(fourth) < 0.2 * np.ptp(third):
        return options[1]
    return None


def _sign(first: Floats, second: Floats, positions: Floats) -> int:
    """Return the number of signs for ``id frame`` minus those for ``frame id``."""
    ids_first, frames_first = _Steps(first, second, positions), _Steps(second, first, positions)
    if not ids_first.count or not frames_first.count:
        return SURE * (bool(ids_first.count) - bool(frames_first.count))
    return (
        4 * _smaller(ids_first.bend, frames_first.bend, 3.0)
        + _smaller(ids_first.length, frames_first.length, 1.5)
        + 2 * _larger(ids_first.contiguous, frames_first.contiguous, 0.2)
        + 2 * _smaller(float(_common_step(first)), float(_common_step(second)), 1.5)
        + _smaller(float(len(np.unique(first))), float(len(np.unique(second))), 1.3)
    )


class _Steps:
    """Statistics of people's steps in one order: number, size, bend, share of single frames."""

    def __init__(self, ids: Floats, frames: Floats, positions: Floats) -> None:
        order = np.lexsort((frames, ids))
        is_same = np.diff(ids[order]) == 0
        gaps = np.diff(frames[order])
        steps = np.diff(positions[order], axis=0)
        self.count = int(is_same.sum())
        if not self.count:
            return
        self.length = float(np.median(np.hypot(*steps[is_same].T)))
        self.contiguous = float(np.mean(gaps[is_same] == _common_step(frames)))
        is_pair = is_same[1:] & is_same[:-1] & (gaps[1:] == gaps[:-1])
        bends = np.hypot(*np.diff(steps, axis=0)[is_pair].T)
        self.bend = float(np.median(bends)) if len(bends) else float("nan")


def _smaller(a: float, b: float, ratio: float) -> int:
    """Return 1 if a is clearly the smaller, -1 if b is, else 0; 0 for NaN."""
    return int(a * ratio < b) - int(b * ratio < a)


def _larger(a: float, b: float, difference: float) -> int:
    return int(a > b + difference) - int(b > a + difference)


def _common_step(values: Floats) -> int:
    """Return the common divisor of the steps between distinct values."""
    steps = np.diff(np.unique(values)).astype(np.int64)
    return int(np.gcd.reduce(steps)) if len(steps) else 1


def _is_clock(cells: Floats, id_column: int, frame_column: int) -> bool:
    """Return True if the third column increases with frames, and people move in the fourth."""
    ids, frames, third, fourth = cells[:, [id_column, frame_column, 2, 3]].T
    if len(np.unique(ids)) < 2 or not np.ptp(frames) or not np.ptp(third):
        return False
    order = np.lexsort((frames, ids))
    moves = np.diff(fourth[order])[np.diff(ids[order]) == 0]
    return bool(moves.any() and np.corrcoef(frames, third)[0, 1] > 1.0 - 1e-6)


def _check_velocities(fault: str, cells: Floats, sign: int, xy: list[int], v: list[int]) -> None:
    """Reject velocity columns that do not point along people's steps."""
    ids, frames = (cells[:, 0], cells[:, 1]) if sign > 0 else (cells[:, 1], cells[:, 0])
    order = np.lexsort((frames, ids))
    is_same = np.diff(ids[order]) == 0
    steps = np.diff(cells[order][:, xy], axis=0)[is_same]
    speeds = cells[order][:-1, v][is_same]
    size = np.sqrt(np.sum(steps**2) * np.sum(speeds**2))
    if size and np.sum(steps * speeds) < 0.5 * size:
        raise InvalidInput(fault)
