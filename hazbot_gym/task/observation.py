"""Observation: one table of fields, used by the encoder, the decoder and the docs.

Every field has physical bounds; the observation holds it divided by its scale, so that all entries
lie near [-1, 1]. Information tiers: ``sonar`` has no person fields; ``tracks`` has the tracker's
output; ``privileged`` has the same fields filled from the true state. The first fields are the
ranges of the sensor ring; the others do not depend on it. Environments with gas have the fields of
the gas sensor before those of people.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, cached_property
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.gas_sensor import reading_rate
from hazbot_gym.core.geometry import clip, norm, path_length, path_pose
from hazbot_gym.core.jit import lean_kernel, routine, scalar
from hazbot_gym.core.patterns import closest_approach
from hazbot_gym.core.sensor_ring import RINGS, RangeSensor, Ring, Sensors, sensors_of
from hazbot_gym.core.state import (
    CONFRONTING,
    CROSSING,
    FASTEST_NOMINAL_MPS,
    GAS_HISTORY,
    PATTERN_NAMES,
    PERSON_SLOTS,
    TOP_SPEED_MPS,
    Floats,
    Ints,
    Records,
    RobotRecord,
    TrackRecord,
)
from hazbot_gym.errors import InvalidInput

if TYPE_CHECKING:
    from hazbot_gym.config import Config

LOOK_AHEAD_M = 1.0  # look-ahead distances of the path's curvature
SONAR_RANGE_M = 4.0
TRACKER_RANGE_M = 8.0
HORIZON_S = 8.0  # upper bound of the time to closest approach


class Field(NamedTuple):
    """One entry of the observation."""

    name: str
    unit: str
    low: float  # physical bounds; values are clipped to them
    high: float
    scale: float  # the observation holds value / scale
    meaning: str


def _field(
    name: str, unit: str, low: float, high: float, meaning: str, scale: float | None = None
) -> Field:
    return Field(name, unit, low, high, scale or max(abs(low), abs(high)), meaning)


def _person_field(slot: int, field: Field) -> Field:
    name, meaning = f"person{slot}_{field.name}", f"person {slot}: {field.meaning}"
    return field._replace(name=name, meaning=meaning)


def _range_field(sensor: RangeSensor) -> Field:
    meaning = f"ultrasonic, {sensor.name.replace('_', ' ')}"
    return _field(f"range_{sensor.name}_m", "m", 0.0, SONAR_RANGE_M, meaning)


ROBOT_FIELDS = (
    # Bounds for the largest nominal speed, on curves with a radius of 0.5 m; scales for 0.5 m/s.
    _field("speed_mps", "m/s", -TOP_SPEED_MPS, TOP_SPEED_MPS, "linear velocity v", 1.0),
    _field("yaw_rate_radps", "rad/s", -5.0, 5.0, "angular velocity omega", 2.0),
    _field("command_mps", "m/s", 0.0, FASTEST_NOMINAL_MPS, "speed commanded last", 1.0),
)
TRACKING_FIELDS = (
    _field("x_e_m", "m", -0.5, 0.5, "along-track error, actual minus reference"),
    _field("y_e_m", "m", -0.5, 0.5, "cross-track error"),
    _field("theta_e_rad", "rad", -0.5, 0.5, "heading error"),
    _field("remaining_m", "m", 0.0, 25.0, "path left to go"),
    _field("curvature_ahead_per_m", "1/m", -2.0, 2.0, f"path curvature {LOOK_AHEAD_M:g} m ahead"),
)
GAS_FIELDS = (
    _field("gas_reading", "-", -2.0, 10.0, "gas sensor, filtered, in units of the alarm threshold"),
    _field("gas_rate_per_s", "1/s", -5.0, 5.0, "rate of this reading"),
    _field("gas_since_peak_s", "s", 0.0, 60.0, "time since the largest reading so far"),
    _field("gas_alarmed", "-", 0.0, 1.0, "1 from the first alarm of the gas sensor on"),
    # A memory for policies without one. It also gives observations with gas a size of their own.
    *(
        _field(f"gas_reading_{k}s", "-", -2.0, 10.0, f"the reading {k} s ago, to a second")
        for k in range(1, GAS_HISTORY + 1)
    ),
)
PERSON_FIELDS = (
    _field("present", "-", 0.0, 1.0, "1 if this slot holds a person"),
    _field("distance_m", "m", 0.0, TRACKER_RANGE_M, "distance between centres"),
    _field("bearing_sin", "-", -1.0, 1.0, "sine of the direction from the robot, left positive"),
    _field("bearing_cos", "-", -1.0, 1.0, "cosine of that direction"),
    _field("speed_mps", "m/s", 0.0, 3.0, "speed of the person"),
    _field("across_mps", "m/s", -3.0, 3.0, "velocity across the line of sight, left positive"),
    _field("closing_mps", "m/s", -5.5, 5.5, "rate at which the distance shrinks", 3.5),
    _field("time_to_closest_s", "s", 0.0, HORIZON_S, "time to closest approach, straight on"),
    _field("closest_m", "m", 0.0, TRACKER_RANGE_M, "distance then"),
    *(_field(name, "-", 0.0, 1.0, f"1 if the walking pattern is {name}") for name in PATTERN_NAMES),
)
OTHER_FIELDS = (*ROBOT_FIELDS, *TRACKING_FIELDS, *GAS_FIELDS, *PERSON_FIELDS)  # all but the ranges
_FAR = ("distance_m", "time_to_closest_s", "closest_m")
_EMPTY = np.array([float(field.name in _FAR) for field in PERSON_FIELDS], np.float32)
_OWN, _GAS = len(ROBOT_FIELDS) + len(TRACKING_FIELDS), len(GAS_FIELDS)
_PER_PERSON = len(PERSON_FIELDS)
_LOW = np.array([field.low for field in OTHER_FIELDS])
_HIGH = np.array([field.high for field in OTHER_FIELDS])
_SCALE = np.array([field.scale for field in OTHER_FIELDS])


class Layout:
    """The fields of an observation, in its order."""

    def __init__(self, sensors: Sensors, *, person_slots: int, has_gas: bool = False) -> None:
        self.sensors = sensors
        self.person_slots = person_slots
        self.has_gas = has_gas
        self.fields = (
            *(_range_field(sensor) for sensor in sensors),
            *ROBOT_FIELDS,
            *TRACKING_FIELDS,
            *(GAS_FIELDS if has_gas else ()),
            *(_person_field(i, field) for i in range(person_slots) for field in PERSON_FIELDS),
        )

    @property
    def has_people(self) -> bool:
        """True if there are fields of people."""
        return self.person_slots > 0

    @cached_property
    def width(self) -> int:
        """Number of entries."""
        return len(self.fields)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the entries."""
        return tuple(field.name for field in self.fields)

    @cached_property
    def low(self) -> npt.NDArray[np.float32]:
        """Lower bounds of the entries as observed, shape (width,)."""
        return np.array([field.low / field.scale for field in self.fields], np.float32)

    @cached_property
    def high(self) -> npt.NDArray[np.float32]:
        """Upper bounds of the entries as observed, shape (width,)."""
        return np.array([field.high / field.scale for field in self.fields], np.float32)

    @cached_property
    def _scale(self) -> Floats:
        return np.array([field.scale for field in self.fields])

    @cached_property
    def _bounds(self) -> tuple[Floats, Floats]:
        low, high = zip(*((field.low, field.high) for field in self.fields), strict=True)
        return np.array(low), np.array(high)

    def decode(self, observation: npt.ArrayLike) -> dict[str, Floats]:
        """Decode every field to its unit, by name; leading axes of (..., width) are kept."""
        physical = np.asarray(observation, dtype=np.float64) * self._scale
        return {name: physical[..., i] for i, name in enumerate(self.names)}

    def encode(self, seen: Mapping[str, npt.ArrayLike]) -> npt.NDArray[np.float32]:
        """Encode fields in their units, by name: the reverse of ``decode``, shape (..., width).

        Values are clipped to their bounds as in the simulator; NaN stays NaN.

        Raises:
            InvalidInput: A field is missing, or is not one of the layout.
        """
        for name in self.names:
            if name not in seen:
                raise InvalidInput(f"observation: the field {name} is missing")
        for name in seen:
            if name not in self.names:
                allowed = ", ".join(self.names)
                raise InvalidInput(f"observation: given a field {name!r}, allowed are {allowed}")
        fields = [np.asarray(seen[name], np.float64) for name in self.names]
        physical = np.stack(np.broadcast_arrays(*fields), axis=-1)
        return np.asarray(np.clip(physical, *self._bounds) / self._scale, np.float32)


TIERS = ("sonar", "tracks", "privileged")


@cache
def layout_with(sensors: Sensors, person_slots: int, has_gas: bool) -> Layout:
    """Return the layout with some sensors, person slots and perhaps gas, always the same one."""
    return Layout(sensors, person_slots=person_slots, has_gas=has_gas)


def layout_for(
    tier: str,
    ring: Ring = "paper",
    *,
    has_gas: bool = False,
    person_slots: int = PERSON_SLOTS,
) -> Layout:
    """Return the layout of a tier's observations.

    Args:
        tier: One of ``TIERS``.
        ring: The ring of range sensors.
        has_gas: Whether there is a gas sensor.
        person_slots: Number of people, on tiers that observe them.
    """
    return layout_with(sensors_of(ring), 0 if tier == "sonar" else person_slots, has_gas)


def layout_in(config: Config) -> Layout:
    """Return the layout of the observations of an environment.

    Raises:
        InvalidInput: It is no config, or its observations are taken for others (``layout_of``).
    """
    if not hasattr(config, "tier"):  # such as the environment itself
        raise InvalidInput(f"config: given {config!r}, allowed is env.unwrapped.config")
    layout = layout_for(
        config.tier,
        config.sensors.ring,
        has_gas=config.gas is not None,
        person_slots=config.person_slots,
    )
    other = KNOWN.get(layout.width, layout)
    if other.names != layout.names:
        raise InvalidInput(
            f"person_slots: given {config.person_slots} with {len(layout.sensors)} range sensors, "
            f"whose observation has as many entries as {_told(other)}; allowed are others"
        )
    return layout


Family = dict[int, Layout]  # layouts by their width, which tells them apart


@cache
def _family(ring: Ring, person_slots: int) -> Family:
    """Return the layouts of observations with a ring and a number of person slots."""
    layouts = (
        layout_for(tier, ring, has_gas=gas, person_slots=person_slots)
        for gas in (False, True)
        for tier in TIERS
    )
    return {layout.width: layout for layout in layouts}


@cache
def _family_of(layout: Layout) -> Family:
    """Return the layouts with the same sensors; a ring as large as a named one is taken for it."""
    same_size = [named for named in RINGS.values() if len(named) == len(layout.sensors)]
    ring = same_size[0] if same_size else layout.sensors
    return _family(ring, layout.person_slots or PERSON_SLOTS)


LAYOUTS = {tier: layout_for(tier) for tier in TIERS}  # of the paper's ring
KNOWN: Family = {
    width: layout
    for ring in RINGS
    for width, layout in _family(cast(Ring, ring), PERSON_SLOTS).items()
}
_readable = ContextVar("_readable", default=KNOWN)


@contextmanager
def observing(config: Config) -> Iterator[None]:
    """Let policies read the observations of an environment, in this context.

    An observation holds no names, and ``predict`` of Stable-Baselines3 has no argument for them.
    Without this context, ``layout_of`` knows only environments with a named ring and the default
    number of person slots.
    """
    with observing_layout(layout_in(config)):
        yield


@contextmanager
def observing_layout(layout: Layout) -> Iterator[None]:
    """Let policies read observations of a layout, or of another tier with the same sensors."""
    token = _readable.set(_family_of(layout))
    try:
        yield
    finally:
        _readable.reset(token)


def known_layout(width: int) -> Layout | None:
    """Return the layout of observations of a width, if it is known (``observing``)."""
    return _readable.get().get(width)


def layout_of(observation: npt.ArrayLike) -> Layout:
    """Return the layout of an observation (..., width), from the size of its last axis.

    Tiers with the same fields share a layout, so that the width determines it among the
    environments that it can come from (``observing``).

    Raises:
        InvalidInput: The size of the last axis fits no layout.
    """
    width = np.shape(observation)[-1] if np.ndim(observation) else 0
    found = known_layout(width)
    if found is not None:
        return found
    allowed = ", ".join(_told(layout) for layout in _readable.get().values())
    raise InvalidInput(
        f"observation: last axis has {width} entries, allowed are {allowed}; for an environment "
        "with another ring or other person_slots ask within observing(env.unwrapped.config)"
    )


def _told(layout: Layout) -> str:
    people = f"tracks, privileged with {layout.person_slots} people"
    return (
        f"{layout.width} ({people if layout.has_people else 'sonar'} with "
        f"{len(layout.sensors)} range sensors{' and gas' * layout.has_gas})"
    )


def readings(seen: Mapping[str, Floats], sensors: Sensors) -> Floats:
    """Return the range readings (..., sensors) in a decoded observation [m]."""
    return np.stack([seen[_range_field(sensor).name] for sensor in sensors], axis=-1)


def selected(observation: npt.NDArray[np.float32], layout: Layout) -> npt.NDArray[np.float32]:
    """Return observations (..., width) with the fields of a smaller layout only.

    Raises:
        InvalidInput: They lack one of its fields.
    """
    given = layout_of(observation)
    if given is layout or given.names == layout.names:
        return observation
    return observation[..., _columns(given, layout)]


@cache
def _columns(given: Layout, wanted: Layout) -> Ints:
    for name in wanted.names:
        if name not in given.names:
            raise InvalidInput(f"observation: {_told(given)} has no field {name}")
    return np.array([given.names.index(name) for name in wanted.names])


def markdown_table(tier: str = "tracks") -> str:
    """Return the field table of a tier in Gymnasium's form, for docstrings and docs."""
    lines = ["| Num | Observation | Min | Max | Unit | Meaning |", "|---|---|---|---|---|---|"]
    for i, f in enumerate(LAYOUTS[tier].fields):
        low, high = f.low / f.scale, f.high / f.scale
        unit = f.unit if f.scale == 1.0 else f"{f.scale:g} {f.unit}"
        lines.append(f"| {i} | {f.name} | {low:g} | {high:g} | {unit} | {f.meaning} |")
    return "\n".join(lines)


# --- encoding ------------------------------------------------------------------------------------


@scalar
def _put(out: npt.NDArray[np.float32], i: int, value: float, shift: int = 0) -> int:
    """Write one physical value into entry i behind the ranges; return the next entry's index.

    Entry i is field ``i + shift`` of the table.
    """
    field = i + shift
    out[i] = clip(value, _LOW[field], _HIGH[field]) / _SCALE[field]
    return i + 1


@scalar
def _next_nearest(tracks: Records, robot: RobotRecord, beyond: float, last: int) -> int:
    """Return the next nearest visible track after (distance ``beyond``, index ``last``), or -1."""
    best, best_distance = -1, math.inf
    for k in range(tracks.shape[0]):
        if tracks[k].visible == 0:
            continue
        distance = norm(tracks[k].x - robot.x, tracks[k].y - robot.y)
        is_later = distance > beyond or (distance == beyond and k > last)
        if is_later and distance < best_distance:
            best, best_distance = k, distance
    return best


@scalar
def _put_person(
    out: npt.NDArray[np.float32], i: int, track: TrackRecord, robot: RobotRecord
) -> int:
    """Write the fields of one tracked person from entry i on."""
    dx, dy = track.x - robot.x, track.y - robot.y
    cos_t, sin_t = math.cos(robot.theta), math.sin(robot.theta)
    distance = max(norm(dx, dy), 1e-9)
    rel_vx, rel_vy = track.vx - robot.v * cos_t, track.vy - robot.v * sin_t
    time_s, closest_m = closest_approach(dx, dy, rel_vx, rel_vy)
    shift = _OWN + _GAS - i
    i = _put(out, i, 1.0, shift)
    i = _put(out, i, distance, shift)
    i = _put(out, i, (cos_t * dy - sin_t * dx) / distance, shift)
    i = _put(out, i, (cos_t * dx + sin_t * dy) / distance, shift)
    i = _put(out, i, norm(track.vx, track.vy), shift)
    i = _put(out, i, (dx * track.vy - dy * track.vx) / distance, shift)
    i = _put(out, i, -(dx * rel_vx + dy * rel_vy) / distance, shift)
    i = _put(out, i, time_s, shift)
    i = _put(out, i, closest_m, shift)
    for pattern in range(CROSSING, CONFRONTING + 1):
        i = _put(out, i, 1.0 if track.pattern == pattern else 0.0, shift)
    return i


@scalar
def _put_empty(out: npt.NDArray[np.float32], i: int) -> int:
    """Write an empty slot: absent, far away, without approach."""
    for k in range(_PER_PERSON):
        out[i + k] = _EMPTY[k]
    return i + _PER_PERSON


@scalar
def _put_people(out: npt.NDArray[np.float32], i: int, tracks: Records, robot: RobotRecord) -> None:
    """Write the nearest people, from entry i to the end; empty slots where there are fewer."""
    beyond, last = -1.0, -1
    while i < out.shape[0]:
        k = _next_nearest(tracks, robot, beyond, last)
        if k < 0:
            i = _put_empty(out, i)
        else:
            beyond, last = norm(tracks[k].x - robot.x, tracks[k].y - robot.y), k
            i = _put_person(out, i, tracks[k], robot)


def person_fields(tracks: Records, robots: Records, person_slots: int) -> dict[str, float]:
    """Return the person fields that ``observe`` writes, by name and in their units.

    It runs as plain Python, so that nothing is compiled.

    Args:
        tracks: (P,) TRACK records.
        robots: (1,) ROBOT record.
        person_slots: Number of people in the observation.
    """
    fields = [_person_field(i, field) for i in range(person_slots) for field in PERSON_FIELDS]
    out = np.empty(len(fields), np.float32)
    _put_people(out, 0, tracks.view(np.recarray), robots.view(np.recarray)[0])
    return {
        field.name: float(value) * field.scale for field, value in zip(fields, out, strict=True)
    }


@routine
def observe(
    robot: RobotRecord, path: Records, ranges: Floats, tracks: Records, gas: Records,
    out: npt.NDArray[np.float32],
) -> None:  # fmt: skip
    """Write the observation; its length and the number of ranges select the tier.

    Args:
        robot: The robot's record.
        path: (M,) records of the path.
        ranges: (N,) readings of the range sensors [m].
        tracks: (P,) TRACK records.
        gas: (1,) GAS record; (0,) without gas.
        out: (width,) float32, output.
    """
    for k in range(ranges.shape[0]):
        out[k] = clip(ranges[k], 0.0, SONAR_RANGE_M) / SONAR_RANGE_M
    rest, i = out[ranges.shape[0] :], 0
    i = _put(rest, i, robot.v)
    i = _put(rest, i, robot.omega)
    i = _put(rest, i, robot.command)
    i = _put(rest, i, robot.x_e)
    i = _put(rest, i, robot.y_e)
    i = _put(rest, i, robot.theta_e)
    i = _put(rest, i, path_length(path) - robot.s - robot.x_e)
    i = _put(rest, i, path_pose(path, robot.s + LOOK_AHEAD_M)[3])
    for k in range(gas.shape[0]):
        i = _put(rest, i, gas[k].smell.smooth)
        i = _put(rest, i, reading_rate(gas[k].smell))
        i = _put(rest, i, gas[k].smell.since_peak_s)
        i = _put(rest, i, gas[k].smell.has_sounded)
        for j in range(GAS_HISTORY):
            i = _put(rest, i, gas[k].smell.past[j])
    _put_people(rest, i, tracks, robot)


@lean_kernel
def observe_kernel(
    robots: Records, path: Records, ranges: Floats, tracks: Records, gas: Records,
    out: npt.NDArray[np.float32],
) -> None:  # fmt: skip
    """Entry point from Python: ``observe`` for an array of one record."""
    observe(robots[0], path, ranges, tracks, gas, out)
