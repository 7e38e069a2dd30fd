"""The robot as a YAML file, and the check that a policy was made for such a robot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

from annotated_types import Gt, Le, MaxLen, MinLen
from pydantic import ValidationError, model_validator

from hazbot_gym.config import Config
from hazbot_gym.config.parameters import NominalSpeed
from hazbot_gym.config.section import Loose, Section, first_error
from hazbot_gym.core.sensor_ring import (
    MOST_SENSORS,
    PAPER,
    RangeSensor,
    Ring,
    check_ring,
    half_cone_of,
    sensors_of,
)
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.yaml_loader import read_yaml

# Largest differences between robot and simulator, our choice: an error of the ranges as small as
# their noise, and sensors that look at the same things.
POSITION_M, DIRECTION_RAD = 0.03, math.radians(5.0)
SAME = 1e-6  # of speeds and times


class SensorPose(Section):
    """A range sensor in the robot's frame: x ahead, y to the left, from the centre of its axle."""

    name: str
    x_m: float
    y_m: float
    yaw_rad: float  # of its axis, left positive
    half_cone_rad: Annotated[float, Gt(0), Le(1)] = Ultrasonic().half_cone_rad


def poses_of(sensors: tuple[RangeSensor, ...], ultrasonic: Ultrasonic) -> tuple[SensorPose, ...]:
    """Return the poses at which the simulator mounts the sensors of a ring."""
    return tuple(
        SensorPose(
            name=sensor.name,
            x_m=round(ultrasonic.mount_radius_m * math.cos(sensor.angle_rad), 9),
            y_m=round(ultrasonic.mount_radius_m * math.sin(sensor.angle_rad), 9),
            yaw_rad=sensor.angle_rad,
            half_cone_rad=half_cone_of(sensor, ultrasonic.half_cone_rad),
        )
        for sensor in sensors
    )


_DRIVE, _CLOCK = Config().drive, Config().clock


class Robot(Section):
    """Parameters of a robot that a policy depends on; defaults are the simulator's."""

    nominal_speed_mps: NominalSpeed = _DRIVE.nominal_speed_mps
    decision_period_s: Annotated[float, Gt(0)] = _CLOCK.decision_s  # between two steps
    deceleration_mps2: Annotated[float, Gt(0)] = _DRIVE.deceleration_mps2  # that it can brake with
    # In the order of ``ranges_m``
    sensors: Annotated[
        tuple[SensorPose, ...], Loose, MinLen(1), MaxLen(MOST_SENSORS)
    ] = poses_of(PAPER, Ultrasonic())  # fmt: skip

    @model_validator(mode="after")
    def _sensors_make_a_ring(self) -> Robot:
        for sensor in self.sensors:
            if abs(sensor.yaw_rad) > math.pi:
                given = f"given {sensor.yaw_rad:g}, allowed are -pi to pi"
                raise ValueError(f"sensors.{sensor.name}.yaw_rad: {given}")
        try:
            check_ring(self.ring)
        except ValueError as error:
            raise ValueError(f"sensors: {error}") from None
        return self

    @property
    def ring(self) -> tuple[RangeSensor, ...]:
        """The sensors, for the layout of observations."""
        return tuple(RangeSensor(each.name, each.yaw_rad) for each in self.sensors)


def load_robot(path: Path | str) -> Robot:
    """Return the robot in a YAML file.

    Raises:
        InvalidInput: The file cannot be read, or a value is not allowed; one line.
    """
    try:
        return Robot.model_validate(read_yaml(Path(path), "robot"))
    except ValidationError as error:
        raise InvalidInput(f"robot: {path}: {first_error(error, Robot)}") from error


def simulated_robot(ring: Ring, ultrasonic: Ultrasonic | None = None, **values: float) -> Robot:
    """Return the robot of the simulator with a ring of sensors."""
    poses = poses_of(sensors_of(ring), ultrasonic or Ultrasonic())
    return Robot.model_validate({"sensors": poses, **values})


class _Difference(NamedTuple):
    field: str
    given: float
    needed: float
    tolerance: float


def check_agreement(robot: Robot, needed: Robot, policy: str) -> None:
    """Refuse a robot that differs from the one that a policy was made for.

    Args:
        robot: The robot.
        needed: The robot of the simulator in which the policy was trained or tuned.
        policy: Name of the policy, for the message.

    Raises:
        InvalidInput: The first difference; one line.
    """
    for field, given, made_for, tolerance in _differences(robot, needed):
        if not abs(given - made_for) <= tolerance:
            raise InvalidInput(
                f"robot.{field}: given {given:g}, but {policy} is made for {made_for:g}"
            )
    if robot.deceleration_mps2 < needed.deceleration_mps2 - SAME:
        raise InvalidInput(
            f"robot.deceleration_mps2: given {robot.deceleration_mps2:g}, but {policy} counts on "
            f"at least {needed.deceleration_mps2:g}"
        )


def _differences(robot: Robot, needed: Robot) -> Iterator[_Difference]:
    for field in ("nominal_speed_mps", "decision_period_s"):
        yield _Difference(field, getattr(robot, field), getattr(needed, field), SAME)
    count, wanted = len(robot.sensors), len(needed.sensors)
    yield _Difference("sensors, their number", count, wanted, 0.0)
    for own, other in zip(robot.sensors, needed.sensors, strict=True):
        if own.name != other.name:
            raise InvalidInput(
                f"robot.sensors: given {own.name!r} where the policy expects {other.name!r}"
            )
        turn_rad = math.remainder(own.yaw_rad - other.yaw_rad, math.tau)
        at = f"sensors.{own.name}"
        yield _Difference(f"{at}.yaw_rad", other.yaw_rad + turn_rad, other.yaw_rad, DIRECTION_RAD)
        yield _Difference(f"{at}.x_m", own.x_m, other.x_m, POSITION_M)
        yield _Difference(f"{at}.y_m", own.y_m, other.y_m, POSITION_M)
        half = other.half_cone_rad
        yield _Difference(f"{at}.half_cone_rad", own.half_cone_rad, half, DIRECTION_RAD)
