"""Readings of a robot in one decision: checks, and the causes for which a robot is stopped."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

from hazbot_gym.errors import HazbotError
from hazbot_gym.runtime.people import Given, Person, as_people
from hazbot_gym.task.observation import (
    GAS_FIELDS,
    ROBOT_FIELDS,
    SONAR_RANGE_M,
    TRACKING_FIELDS,
    Layout,
)

Cause = Literal["no readings", "stale", "missing", "not finite", "impossible", "policy"]

TOO_FAST = 2.0  # times the nominal speed; no drive overshoots that much
FASTEST_MPS = 10.0  # nobody runs faster


class Stop(NamedTuple):
    """Reason for which the watchdog stops the robot."""

    cause: Cause
    message: str  # one line that names the reading


class _Unusable(Exception):
    def __init__(self, cause: Cause, message: str) -> None:
        super().__init__(message)
        self.stop = Stop(cause, message)


class Readings(NamedTuple):
    """Readings of one decision that can be used."""

    ranges_m: tuple[float, ...]
    fields: dict[str, float]  # all others but those of people, by name
    people: list[Person]


def own_names(layout: Layout) -> tuple[str, ...]:
    """Return the fields of a layout that are neither ranges nor people's."""
    fields = (*ROBOT_FIELDS, *TRACKING_FIELDS, *(GAS_FIELDS if layout.has_gas else ()))
    return tuple(field.name for field in fields)


def checked(
    layout: Layout,
    ranges_m: Sequence[float] | Mapping[str, float] | None,
    people: Given | None,
    fields: Mapping[str, float | None],
    nominal_mps: float,
) -> Readings | Stop:
    """Return readings that can be used, or the reason why they cannot.

    Args:
        layout: Layout of the policy's observations.
        ranges_m: In the order of the layout's sensors, or by their names. Infinity is no echo, and
            minus infinity an echo too near to measure (REP 117 of ROS).
        people: As of ``SpeedController.step``.
        fields: The other readings, by name.
        nominal_mps: Nominal speed of the robot.
    """
    possible = _possible(nominal_mps)
    try:
        names = [sensor.name for sensor in layout.sensors]
        ranges = tuple(_ranges(names, ranges_m))
        own = {name: _number(name, fields.get(name)) for name in own_names(layout)}
        for name, number in own.items():
            _check_possible(name, number, *possible.get(name, (-math.inf, math.inf)))
        return Readings(ranges, own, _people(people) if layout.has_people else [])
    except _Unusable as error:
        return error.stop
    except (TypeError, ValueError, AttributeError) as error:  # no numbers, or of another shape
        return Stop("impossible", f"readings cannot be read: {' '.join(str(error).split())}")


def _ranges(
    names: Sequence[str], given: Sequence[float] | Mapping[str, float] | None
) -> Iterator[float]:
    if given is None:
        raise _Unusable("missing", "ranges_m is missing")
    if isinstance(given, Mapping):
        by_name = given
    elif len(given) == len(names):
        by_name = dict(zip(names, given, strict=True))
    else:
        message = f"ranges_m: given {len(given)} ranges, the ring has {len(names)}"
        raise _Unusable("missing", f"{message}: {', '.join(names)}")
    for name in names:
        value, what = by_name.get(name), f"ranges_m of {name}"
        if value is not None and math.isinf(value):
            yield SONAR_RANGE_M if value > 0.0 else 0.0
            continue
        range_m = _number(what, value)
        if range_m < 0.0:
            raise _Unusable("impossible", f"{what}: given {range_m:g} m, possible is 0 or more")
        yield range_m


def _possible(nominal_mps: float) -> dict[str, tuple[float, float]]:
    """Return the range of possible values of some readings.

    Others come from a broken sensor or from other units. Tracking errors may be larger than an
    observation can say: they are clipped, as in the simulator.
    """
    top_mps = TOO_FAST * nominal_mps
    return {field.name: (field.low, field.high) for field in ROBOT_FIELDS} | {
        "speed_mps": (-top_mps, top_mps),
        "command_mps": (0.0, top_mps),
        "theta_e_rad": (-math.pi, math.pi),
        "gas_alarmed": (0.0, 1.0),
    }


def _check_possible(name: str, number: float, low: float, high: float) -> None:
    """Raise if a number is not possible."""
    if not low <= number <= high:
        raise _Unusable("impossible", f"{name}: given {number:g}, possible is {low:g} to {high:g}")


def _number(name: str, value: float | None) -> float:
    """Return a finite number."""
    if value is None:
        raise _Unusable("missing", f"{name} is missing")
    number = float(value)
    if not math.isfinite(number):
        raise _Unusable("not finite", f"{name}: given {number}")
    return number


def _people(given: Given | None) -> list[Person]:
    if given is None:
        raise _Unusable("missing", "people is missing; if the tracker sees nobody, give []")
    people = as_people(given)
    for i, person in enumerate(people):
        for name in ("x_m", "y_m", "vx_mps", "vy_mps"):
            _number(f"people[{i}].{name}", getattr(person, name))
        if math.hypot(person.vx_mps, person.vy_mps) > FASTEST_MPS:
            message = f"people[{i}]: walks faster than {FASTEST_MPS:g} m/s"
            raise _Unusable("impossible", message)
    return people


def too_old(age_s: float, allowed_s: float) -> Stop | None:
    """Return the stop of old readings, or of an age that is none."""
    try:
        is_fresh = 0.0 <= float(age_s) <= allowed_s
    except (TypeError, ValueError):
        is_fresh = False
    if is_fresh:
        return None
    return Stop("stale", f"readings are of the age {age_s!r} s, allowed is 0 to {allowed_s:g} s")


def refused_by_policy(error: HazbotError) -> Stop:
    """Return the stop of a policy that gives no answer."""
    return Stop("policy", str(error))
