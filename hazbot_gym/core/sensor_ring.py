"""The ring of range sensors as data: their number, directions and cones.

``paper``: two in front at +-15 deg, one on each side (section 2). ``six``: two more of the same in
the middle of the sectors from 30 to 75 deg, in which the paper's ring is blind.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Annotated, Literal, NamedTuple, Protocol

import numpy as np
from annotated_types import Ge, Gt, Le

from hazbot_gym.core.elementary import sin_cos
from hazbot_gym.core.state import Records

MOST_SENSORS = 16
FRONT_RAD = math.radians(30.0)  # sensors at most this far from the heading point ahead
NAMESAKE_RAD = math.radians(20.0)  # a sensor points at most this far from its namesake
NAME = re.compile(r"[a-z][a-z0-9_]{0,31}")


class RangeSensor(NamedTuple):
    """One sensor of the ring."""

    name: str
    angle_rad: Annotated[float, Ge(-math.pi), Le(math.pi)]  # of its axis, left of the heading
    half_cone_rad: Annotated[float, Gt(0), Le(1.0)] | None = None  # None: ultrasonic.half_cone_rad


Sensors = tuple[RangeSensor, ...]
Ring = Literal["paper", "six"] | Sensors

PAPER: Sensors = (
    RangeSensor("front_left", math.radians(15.0)),
    RangeSensor("front_right", math.radians(-15.0)),
    RangeSensor("left", math.pi / 2),
    RangeSensor("right", -math.pi / 2),
)
SIX: Sensors = (
    *PAPER,
    RangeSensor("diagonal_left", math.radians(52.5)),
    RangeSensor("diagonal_right", math.radians(-52.5)),
)
RINGS: dict[str, Sensors] = {"paper": PAPER, "six": SIX}

RING = np.dtype(
    [
        ("axis_x", "f8"),  # unit vector along the axis in the robot frame: ahead, left
        ("axis_y", "f8"),
        ("cos_half", "f8"),  # of the half opening angle
        ("sin_half", "f8"),
        ("mirror", "i8"),  # index of the sensor whose echo it hears in cross-talk
        ("is_ahead", "i8"),  # 1 if it points ahead
    ],
    align=True,
)  # a sensor, for kernels


class SensorRecord(Protocol):
    """One element of an array of ``RING``."""

    axis_x: float
    axis_y: float
    cos_half: float
    sin_half: float
    mirror: int
    is_ahead: int


def sensors_of(ring: Ring) -> Sensors:
    """Return the sensors of a ring, by name or in full."""
    return RINGS[ring] if isinstance(ring, str) else ring


def names_of(ring: Ring) -> tuple[str, ...]:
    """Return the names of a ring's sensors."""
    return tuple(sensor.name for sensor in sensors_of(ring))


def half_cone_of(sensor: RangeSensor, common_rad: float) -> float:
    """Return a sensor's half opening angle: its own, or that of all sensors [rad]."""
    return common_rad if sensor.half_cone_rad is None else sensor.half_cone_rad


def is_ahead(sensor: RangeSensor) -> bool:
    """Return True if a sensor points ahead."""
    return abs(sensor.angle_rad) <= FRONT_RAD


def check_ring(ring: Ring) -> Ring:
    """Return a ring that can be used.

    An observation tells a policy only the number of sensors, by which the policy takes the ring for
    a named one. A ring as large as a named one therefore needs its names in its order, and nearly
    its directions.

    Raises:
        ValueError: The number of sensors or a name cannot be used, or a sensor is unlike its
            namesake.
    """
    sensors, names = sensors_of(ring), names_of(ring)
    if not 1 <= len(names) <= MOST_SENSORS:
        raise ValueError(f"given {len(names)} sensors, allowed are 1 to {MOST_SENSORS}")
    for name in names:
        if not NAME.fullmatch(name):
            raise ValueError(f"name: given {name!r}, allowed are a-z, 0-9 and _, from a letter on")
        if names.count(name) > 1:
            raise ValueError(f"name: given {name!r} twice, allowed is once")
    for label, known in RINGS.items():
        if len(known) == len(sensors):
            _check_namesakes(sensors, known, label)
    return ring


def _check_namesakes(sensors: Sensors, known: Sensors, label: str) -> None:
    """Compare a ring with the named one of its size."""
    names = ", ".join(names_of(sensors))
    if names != ", ".join(names_of(known)):
        allowed = ", ".join(names_of(known))
        raise ValueError(f"given {names}, allowed for {len(known)} sensors is {allowed}")
    for sensor, namesake in zip(sensors, known, strict=True):
        off_rad = math.remainder(sensor.angle_rad - namesake.angle_rad, math.tau)
        if abs(off_rad) > NAMESAKE_RAD:
            raise ValueError(
                f"angle_rad: given {sensor.angle_rad:g} for {sensor.name!r}, allowed is at most "
                f"{NAMESAKE_RAD:.2g} from the {namesake.angle_rad:.3g} of {label!r}"
            )


def ring_table(sensors: Iterable[RangeSensor], half_cone_rad: float) -> Records:
    """Return a ring (N,) of ``RING`` records.

    Args:
        sensors: The sensors.
        half_cone_rad: Half opening angle of those without their own.
    """
    sensors = tuple(sensors)
    table = np.zeros(len(sensors), RING)
    for row, sensor in zip(table, sensors, strict=True):
        sine, cosine = sin_cos(sensor.angle_rad)
        row["axis_x"] = cosine if abs(cosine) > 1e-15 else 0.0  # exactly to the side
        row["axis_y"] = sine
        row["sin_half"], row["cos_half"] = sin_cos(half_cone_of(sensor, half_cone_rad))
        row["mirror"] = _mirror(sensor, sensors)
        row["is_ahead"] = is_ahead(sensor)
    return table


def _mirror(sensor: RangeSensor, sensors: Sensors) -> int:
    """Return the index of the other sensor that is nearest to the opposite angle."""
    others = [i for i, other in enumerate(sensors) if other is not sensor]
    off = [abs(math.remainder(sensors[i].angle_rad + sensor.angle_rad, math.tau)) for i in others]
    return others[int(np.argmin(off))] if others else 0
