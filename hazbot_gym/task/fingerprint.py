"""What was drawn for a scenario, in figures, and a hash that changes with any of them.

Figures are rounded to a millionth (of a metre, a second, a metre a second): the last digits of a
logarithm are the processor's own, and move nobody.
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
# Fields of PERSON that are drawn, or follow from what is; the name says the unit.
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
    """Return what was drawn for each person who comes."""
    return [
        {name: round(person[field].item(), DIGITS) for name, field in PARAMETERS.items()}
        for person in scenario.people
        if person["status"] != GONE
    ]


def fingerprint(scenario: Scenario) -> str:
    """Return a hash of the people, of walls and path, and of where recorded people stand first."""
    place = scenario.place
    people = np.array([list(person.values()) for person in parameters(scenario)])
    path = np.stack([place.path[name] for name in PATH_PIECE.names or ()], axis=1)
    total = hashlib.sha256(scenario.name.encode())
    for figures in (people, place.walls, path, _standing_first(scenario.recording)):
        total.update(str(figures.shape).encode())
        total.update(_in_millionths(figures).tobytes())
    return total.hexdigest()[:LENGTH]


def _standing_first(recording: Stretch) -> Floats:
    """Return where recorded people stand at first, (1, S, 2) [m], NaN where a slot is empty.

    (0, S, 2) if nobody is replayed.
    """
    slots = len(recording.slots) - 1
    positions = np.full((min(recording.steps, 1), slots, 2), np.nan)
    for slot in range(slots if recording.steps else 0):
        row, end = rows_from(recording, slot, 0)
        if row < end:
            positions[0, slot] = recording.positions[row]
    return positions


def _in_millionths(figures: Floats) -> npt.NDArray[np.int64]:
    """Return figures as whole numbers, so that neither -0.0 nor the byte order can show."""
    whole: Floats = np.rint(np.nan_to_num(figures, nan=-1.0) * 10**DIGITS)
    return whole.astype(np.dtype("<i8"))
