"""Fingerprint of a scenario: its drawn values, and their hash.

Values are rounded to 1e-6 (m, s, m/s), since the last digits of logarithms depend on the processor.
"""

from __future__ import annotations

import hashlib

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.recorded_table import Stretch, rows_from
from hazbot_gym.core.state import GONE, PATH_PIECE, Floats
from hazbot_gym.task.scenario import Scenario

DIGITS = 6
LENGTH = 16  # of a hash, in hexadecimal digits
# Fields of PERSON that are drawn or derived; the name contains the unit.
PARAMETERS = {
    "route": "route",
    "reaction": "reaction",
    "model": "model",
    "desired_speed_mps": "desired_speed",
    "enters_s": "enters_s",
    "s_m": "s",
    "offset_m": "offset",
    "sidestep_s_m": "sidestep_s",
    "sidestep_offset_m": "sidestep_offset",
    "x_m": "x",
    "y_m": "y",
    "radius_m": "radius",
}


def parameters(scenario: Scenario) -> list[dict[str, float]]:
    """Return the drawn values of each person."""
    return [
        {name: round(person[field].item(), DIGITS) for name, field in PARAMETERS.items()}
        for person in scenario.people
        if person["status"] != GONE
    ]


def fingerprint(scenario: Scenario) -> str:
    """Return a hash of people, walls, path, and first positions of recorded people."""
    place = scenario.place
    people = np.array([list(person.values()) for person in parameters(scenario)])
    path = np.stack([place.path[name] for name in PATH_PIECE.names or ()], axis=1)
    total = hashlib.sha256(scenario.name.encode())
    figures_of = [people, place.walls, path, _standing_first(scenario.recording)]
    if len(scenario.gas):  # other scenarios keep their hash
        figures_of.append(np.array([scenario.gas[0]["leak"].tolist()]))
    for figures in figures_of:
        total.update(str(figures.shape).encode())
        total.update(_in_millionths(figures).tobytes())
    return total.hexdigest()[:LENGTH]


def _standing_first(recording: Stretch) -> Floats:
    """Return the first positions of recorded people, (1, S, 2) [m], NaN for empty slots.

    (0, S, 2) without replayed people.
    """
    slots = len(recording.slots) - 1
    positions = np.full((min(recording.steps, 1), slots, 2), np.nan)
    for slot in range(slots if recording.steps else 0):
        row, end = rows_from(recording, slot, 0)
        if row < end:
            positions[0, slot] = recording.positions[row]
    return positions


def _in_millionths(figures: Floats) -> npt.NDArray[np.int64]:
    """Return values as whole numbers, independent of -0.0 and byte order."""
    whole: Floats = np.rint(np.nan_to_num(figures, nan=-1.0) * 10**DIGITS)
    return whole.astype(np.dtype("<i8"))
