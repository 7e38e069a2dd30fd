"""State records: robot, wheel, person, track, gas and place as record arrays.

Both engines, the sensors, the observation and the reward use these records only. SI units, radians
counter-clockwise, x forward, y left. A record array is passed to kernels as it is; in kernels its
fields are attributes (``people[i].vx``).
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Records = npt.NDArray[np.void]

# --- bodies (the robot's mass: paper) ------------------------------------------------------------

ROBOT_RADIUS_M, ROBOT_MASS_KG = 0.30, 34.0
FASTEST_NOMINAL_MPS = 2.0  # largest nominal speed that a config may have
TOP_SPEED_MPS = 2.5  # bound of the robot's speed, with the overshoot of its wheel loops
PERSON_RADIUS_M, PERSON_MASS_KG = 0.20, 80.0  # mass: Helbing, Farkas and Vicsek 2000

# --- the robot -----------------------------------------------------------------------------------

ROBOT = np.dtype(
    [
        ("x", "f8"),  # midpoint M of the driven axle [m]
        ("y", "f8"),
        ("theta", "f8"),  # heading, not wrapped [rad]
        ("v", "f8"),  # actual linear velocity [m/s]
        ("omega", "f8"),  # actual yaw rate [rad/s]
        ("command", "f8"),  # last commanded speed [m/s]
        ("obeyed", "f8"),  # effective command of the drive, after the latency [m/s]
        ("v_ref", "f8"),  # that speed behind the slew limit: the reference point's [m/s]
        ("s", "f8"),  # reference point's arc length along the path [m]
        ("x_e", "f8"),  # pose error, actual minus reference, in the robot frame (eq 10) [m]
        ("y_e", "f8"),
        ("theta_e", "f8"),  # in (-pi, pi] [rad]
        ("y_seen", "f8"),  # cross-track error of the line sensor, if any [m]
    ],
    align=True,
)


class RobotRecord(Protocol):
    """One element of an array of ``ROBOT``, for which numba and numpy each have their own type."""

    x: float
    y: float
    theta: float
    v: float
    omega: float
    command: float
    obeyed: float
    v_ref: float
    s: float
    x_e: float
    y_e: float
    theta_e: float
    y_seen: float


WHEEL = np.dtype(
    [
        ("speed", "f8"),  # actual angular velocity w [rad/s]
        ("drive", "f8"),  # motor input behind the extra lag of plant B
        ("integral", "f8"),  # integral of the control error [rad]
        ("error", "f8"),  # control error of the last step, NaN before the first [rad/s]
        ("derivative", "f8"),  # filtered derivative of the control error [rad/s^2]
    ],
    align=True,
)


class WheelRecord(Protocol):
    """One element of an array of ``WHEEL``."""

    speed: float
    drive: float
    integral: float
    error: float
    derivative: float


RIGHT, LEFT = 0, 1  # wheel 1 is the right one (A1)

# --- people --------------------------------------------------------------------------------------

WAITING, PRESENT, GONE = 0, 1, 2  # not yet entered, walking, left for good

# The paper's four walking patterns (B_j of its fuzzy rules), and the fifth of the track statistics.
NO_PATTERN, CROSSING, ENCOUNTERING, LEADING, CONFRONTING, BESIDE = -1, 0, 1, 2, 3, 4
PATTERN_NAMES = ("crossing", "encountering", "leading", "confronting")

SCRIPTED, SOCIAL_FORCE, REPLAY, OWN = 0, 1, 2, 3  # model of a person's motion; OWN: a user's
REACTION_NAMES = ("attentive", "blind", "wary", "curious")

PERSON = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("vx", "f8"),
        ("vy", "f8"),
        ("radius", "f8"),  # [m]
        ("desired_speed", "f8"),  # [m/s]
        ("enters_s", "f8"),  # time of entry [s]
        ("left_s", "f8"),  # time of the last presence [s]
        ("s", "f8"),  # arc length walked along the route [m]
        ("offset", "f8"),  # lateral offset from the route, left positive [m]
        ("sidestep_s", "f8"),  # arc length at which a scripted walker has stepped aside [m]
        ("sidestep_offset", "f8"),  # its lateral offset from then on [m]
        ("route", "i4"),  # row of the routes; for REPLAY while PRESENT the stay in the recording
        ("model", "i4"),  # SCRIPTED, SOCIAL_FORCE, REPLAY or OWN
        ("reaction", "i4"),  # row of the reaction table (REACTION_NAMES)
        ("status", "i4"),  # WAITING, PRESENT or GONE
        ("blocked", "f8"),  # relative loss of desired speed by the robot, in [0, 1]
        ("next_vx", "f8"),  # next velocity, before the simultaneous update
        ("next_vy", "f8"),
    ],
    align=True,
)


class PersonRecord(Protocol):
    """One element of an array of ``PERSON``."""

    x: float
    y: float
    vx: float
    vy: float
    radius: float
    desired_speed: float
    enters_s: float
    left_s: float
    s: float
    offset: float
    sidestep_s: float
    sidestep_offset: float
    route: int
    model: int
    reaction: int
    status: int
    blocked: float
    next_vx: float
    next_vy: float


PERSON_SLOTS = 3  # tracked people in an observation, by default

TRACK = np.dtype(
    [
        ("visible", "i4"),  # 1 if the tracker reports this person now
        ("pattern", "i4"),  # label held while the person is in view; NO_PATTERN if none yet
        ("x", "f8"),
        ("y", "f8"),
        ("vx", "f8"),
        ("vy", "f8"),
    ],
    align=True,
)


class TrackRecord(Protocol):
    """One element of an array of ``TRACK``."""

    visible: int
    pattern: int
    x: float
    y: float
    vx: float
    vy: float


# --- gas ------------------------------------------------------------------------------------------

GAS_HISTORY = 10  # earlier readings of the gas sensor, one a second

LEAK = np.dtype(
    [
        ("is_there", "i8"),  # 0 without a leak; the other fields are then 0
        ("s_m", "f8"),  # arc length of the path beside the leak
        ("y_m", "f8"),  # lateral position, left of the path positive
        ("strength_ppm", "f8"),  # S, on the centerline 1 m downwind, in an open place
        ("draught_mps", "f8"),  # U, negative against the direction of the path
        ("left_m", "f8"),  # distance from the path to the wall on the left, inf without
        ("right_m", "f8"),  # the same on the right
        ("phase_1", "f8"),  # of the meander [rad]
        ("phase_2", "f8"),
        ("phase_3", "f8"),
    ],
    align=True,
)


class LeakRecord(Protocol):
    """One element of an array of ``LEAK``."""

    is_there: int
    s_m: float
    y_m: float
    strength_ppm: float
    draught_mps: float
    left_m: float
    right_m: float
    phase_1: float
    phase_2: float
    phase_3: float


SMELL = np.dtype(
    [
        ("s_m", "f8"),  # arc length of the path at the sensor
        ("concentration_ppm", "f8"),  # c there
        ("response", "f8"),  # r, without noise
        ("reading", "f8"),  # r with noise / alarm threshold
        ("smooth", "f8"),  # reading behind one filter, and behind both
        ("smoother", "f8"),
        ("peak", "f8"),  # largest smoothed reading so far
        ("since_peak_s", "f8"),  # time since then
        ("alarm", "i8"),  # 1 while the alarm sounds
        ("onset", "i8"),  # 1 if it started in this decision
        ("has_sounded", "i8"),  # 1 from the first alarm on
        ("past", "f8", (GAS_HISTORY,)),  # smooth at the last full seconds, the latest first
    ],
    align=True,
)  # state of a gas sensor


class SmellRecord(Protocol):
    """One element of an array of ``SMELL``."""

    s_m: float
    concentration_ppm: float
    response: float
    reading: float
    smooth: float
    smoother: float
    peak: float
    since_peak_s: float
    alarm: int
    onset: int
    has_sounded: int
    past: Floats


GAS = np.dtype(
    [
        ("leak", LEAK),
        ("smell", SMELL),
        ("is_reported", "i8"),  # 1 once an alarm was caused by gas
        ("false_alarms", "i8"),  # number of other alarms
    ],
    align=True,
)  # an episode's gas: leak, sensor, and the survey so far


class GasRecord(Protocol):
    """One element of an array of ``GAS``."""

    leak: LeakRecord
    smell: SmellRecord
    is_reported: int
    false_alarms: int


NO_CONTACT, WALL = -2, -1  # contact codes other than a person's index

# --- places --------------------------------------------------------------------------------------

PATH_PIECE = np.dtype(
    [
        ("s", "f8"),  # arc length at which the piece starts [m]
        ("length", "f8"),  # [m]
        ("x", "f8"),
        ("y", "f8"),
        ("heading", "f8"),  # tangent at the start [rad]
        ("curvature", "f8"),  # 0 for a straight piece, left turns positive [1/m]
        ("cos", "f8"),  # of the heading
        ("sin", "f8"),
    ],
    align=True,
)

ACROSS, AGAINST, ALONG = 0, 1, 2  # direction of a person's route relative to the robot's path


class Place(NamedTuple):
    """A place as arrays for kernels.

    Attributes:
        walls: (W, 4) segments x1, y1, x2, y2 [m].
        path: (M,) records of type ``PATH_PIECE``, the robot's path.
        routes: (R, K, 3) waypoints of people's routes: x, y and arc length so far [m]; rows shorter
            than K repeat their last waypoint.
        route_kinds: (R,) ACROSS, AGAINST or ALONG, direction relative to the path.
        route_anchors: (R, 2) arc lengths on path and route at their intersection [m].
        route_rooms: (R,) largest lateral offset of people's lanes from the route [m].
        entry_times_s: (R,) entry time of a recorded person on each route, in order; (0,) if people
            are not seeded from a recording.
        entry_speeds_mps: (R,) its speed.
    """

    walls: Floats
    path: Records
    routes: Floats
    route_kinds: Ints
    route_anchors: Floats
    route_rooms: Floats
    entry_times_s: Floats = np.zeros(0)
    entry_speeds_mps: Floats = np.zeros(0)


def records(dtype: np.dtype[np.void], size: int) -> Records:
    """Return ``size`` zeroed records of one of the types above."""
    return np.zeros(size, dtype)


def as_record(parameters: object) -> Records:
    """Return a named tuple of numbers as an array of one record with the same field names.

    Kernels read ``record[0].field`` like the named tuple's own attribute, but a record is handed to
    compiled code seven times faster than a tuple of a dozen numbers. Nested tuples become nested
    records.
    """
    return np.array([_plain(parameters)], dtype=_record_type(parameters))


def _plain(value: object) -> object:
    return tuple(_plain(item) for item in value) if isinstance(value, tuple) else value


def _record_type(parameters: Any) -> np.dtype[np.void]:
    kinds = {bool: "i8", int: "i8", float: "f8"}
    fields = [
        (name, _record_type(value) if isinstance(value, tuple) else kinds[type(value)])
        for name, value in zip(parameters._fields, parameters, strict=True)
    ]
    return np.dtype(fields, align=True)
