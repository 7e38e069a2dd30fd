"""Grayscale line sensor below the robot: eight lamps in a row over the line on the floor.

The paper computes the robot's offset from "the eight light states of the grayscale sensor" (section
5.2) and prints neither spacing nor formula. Here a lamp is lit while it is above the line, and the
offset is the mean position of lit lamps; with none lit, the last offset is kept. Left out: the
slant of the line under a turned robot, and gray between black and white.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt

from hazbot_gym.core.jit import scalar

LAMPS = 8  # (paper section 5.2)


class LineSensor(NamedTuple):
    """A row of lamps across the robot, centred on M; our choice of lengths."""

    pitch_m: Annotated[float, Ge(0)] = 0.0  # spacing of lamps; 0: no sensor, exact error
    line_m: Annotated[float, Gt(0)] = 0.02  # width of the line


@scalar
def seen_offset(y_e: float, last_m: float, sensor: LineSensor) -> float:
    """Return the cross-track error measured by the lamps [m].

    Lamp k = 0..7 is at p_k = (k - 3.5) pitch to the left of M, the line at -y_e; lit are those with
    |p_k + y_e| <= line/2, and y_e is seen as minus their mean place.

    Args:
        y_e: Cross-track error, left of the line positive [m].
        last_m: Previous measurement [m].
        sensor: Sensor geometry.
    """
    lit, places_m = 0, 0.0
    for k in range(LAMPS):
        place_m = (k - 0.5 * (LAMPS - 1)) * sensor.pitch_m
        if abs(place_m + y_e) <= 0.5 * sensor.line_m:
            lit += 1
            places_m += place_m
    return -places_m / lit if lit > 0 else last_m
