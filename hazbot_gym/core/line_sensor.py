"""The grayscale line sensor: eight lamps in a row across the robot, above a line on the floor.

A lamp is lit where it stands over the line. The robot knows its distance from the line only as the
middle of the lit lamps; where none is lit, as what they showed last. The sensor is in the paper's
sections 2 and 5.2, which read the robot's position from "the eight light states"; neither the pitch
of the lamps nor the width of the line is given there: our choices.

Left out: a lamp's own width and shades of gray, and that the lamps see the piece of the line beside
the robot and not the reference point, which x_e sin(theta_e) tells apart: millimetres.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from annotated_types import Ge, Gt

from hazbot_gym.core.jit import scalar

LAMPS = 8  # paper, section 5.2
_MIDDLE = 0.5 * (LAMPS - 1)  # of the row, in lamps from its end


class LineSensor(NamedTuple):
    """A row of lamps, its middle at M; with a line at least as wide as the pitch no gap is dark."""

    pitch_m: Annotated[float, Ge(0)] = 0.0  # from lamp to lamp; 0 = no sensor, the error is known
    line_m: Annotated[float, Gt(0)] = 0.02  # width of the line


@scalar
def lamps_error(y_e: float, held_m: float, sensor: LineSensor) -> float:
    """Return the cross-track error that the lamps show [m].

    The line lies -y_e to the left of M. Seen from the line, lamp k = 0..7 from the left therefore
    tells of an error of (k - 3.5) pitch, and it is lit if that is within half a line's width of
    y_e. The lit ones stand side by side: their middle is that of the first and the last.

    Args:
        y_e: True cross-track error, left positive [m].
        held_m: What the lamps showed last [m].
        sensor: With a pitch above 0.
    """
    first = max(np.ceil((y_e - 0.5 * sensor.line_m) / sensor.pitch_m + _MIDDLE), 0.0)
    last = min(np.floor((y_e + 0.5 * sensor.line_m) / sensor.pitch_m + _MIDDLE), LAMPS - 1.0)
    return (0.5 * (first + last) - _MIDDLE) * sensor.pitch_m if first <= last else held_m
