"""Configuration: every parameter of the problem, validated, with its unit; named scenarios.

Parameters of an equation live beside that equation in ``core`` and are composed here. A config is
given as a ``Config``, as a mapping of deltas on the defaults, or as a YAML file of such deltas.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, get_args, get_origin

import numpy as np
from annotated_types import Ge, Gt, Le, MaxLen
from pydantic import BaseModel, ConfigDict, Strict, ValidationError, model_validator

from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.kinematics import Chassis
from hazbot_gym.core.line_sensor import LineSensor
from hazbot_gym.core.pid import PLANTS, PidGains, Plant
from hazbot_gym.core.social_force import (
    ATTENTIVE,
    CURIOUS,
    INATTENTIVE,
    WARY,
    Reaction,
    SocialForce,
)
from hazbot_gym.core.tracking import TrackingGains
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.errors import InvalidInput, UnknownKeyword
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import read_yaml

Family = Literal["crossing", "encountering", "leading", "confronting", "mixed"]
Loose = Strict(False)  # accepts a list for a tuple, a string for a path; contents are strict

# Bounds beyond any real problem: they catch misplaced digits.
SMALLEST, LARGEST = 1e-12, 1e9  # magnitude of every number but 0
MOST_PEOPLE = 64
MOST_STEPS = 100_000  # of an episode: nearly three hours
MOST_PHYSICS_STEPS = 1000  # of a decision

Count = Annotated[int, Ge(0), Le(MOST_PEOPLE)]
Weight = Annotated[float, Ge(0)]
Weights = Annotated[tuple[Weight, Weight, Weight, Weight], Loose]
Reactions = Annotated[tuple[Reaction, Reaction, Reaction, Reaction], Loose]


class Section(BaseModel):
    """A section of the config: frozen; misspelt keys, NaN and other types are rejected.

    Types are strict: ``"5"``, ``yes`` and ``true`` are no numbers, and 1.0 is no integer. An
    integer is accepted for a float; ``Loose`` marks further conversions.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    @model_validator(mode="before")
    @classmethod
    def _lists_are_whole(cls, values: Any) -> Any:
        """Reject a list that is shorter than its named tuple."""
        for name, field in cls.model_fields.items() if isinstance(values, Mapping) else ():
            for place, names, given in _as_lists(name, field.annotation, values.get(name)):
                if len(given) != len(names):
                    allowed = f"a mapping, or a list of all {len(names)}: {', '.join(names)}"
                    raise ValueError(f"{place}: given {_shown(given)}, allowed is {allowed}")
        return values

    @model_validator(mode="after")
    def _sizes_are_sane(self) -> Self:
        for name in type(self).model_fields:
            for field, number in _floats(name, getattr(self, name)):
                if number != 0.0 and not SMALLEST <= abs(number) <= LARGEST:
                    allowed = f"{SMALLEST:g} to {LARGEST:g}"
                    raise ValueError(f"{field}: given {number!r}, allowed are sizes of {allowed}")
        return self


def _as_lists(field: str, kind: object, value: object) -> Iterator[tuple[str, Any, Any]]:
    """Yield field, names and values of each named tuple given as a list."""
    if not isinstance(value, list | tuple):
        return
    if hasattr(kind, "_fields"):
        yield field, kind._fields, value
    elif get_origin(kind) is tuple:
        for i, (each, part) in enumerate(zip(get_args(kind), value, strict=False)):
            yield from _as_lists(f"{field}.{i}", each, part)
    else:
        for each in get_args(kind):
            yield from _as_lists(field, each, value)


def _floats(field: str, value: object) -> Iterator[tuple[str, float]]:
    """Yield the floats in a field's value and their names, without nested sections."""
    if isinstance(value, float):
        yield field, value
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from _floats(f"{field}.{name}", each)
    elif isinstance(value, tuple | list):
        names = getattr(value, "_fields", range(len(value)))
        yield from _floats(field, dict(zip(names, value, strict=True)))


class Clock(Section):
    """The three periods; each must divide the next one exactly."""

    physics_s: Annotated[float, Ge(1e-4)] = 0.01  # bodies and wheel loops (paper's loop: 10 ms)
    social_s: Annotated[float, Gt(0)] = 0.05  # period of people's velocity updates
    decision_s: Annotated[float, Gt(0), Le(10)] = 0.1  # period of the policy

    @model_validator(mode="after")
    def _periods_divide(self) -> Clock:
        if self.decision_s / self.physics_s > MOST_PHYSICS_STEPS:
            raise ValueError(
                f"physics_s: given {self.physics_s}, allowed are at most {MOST_PHYSICS_STEPS} "
                f"physics steps in decision_s = {self.decision_s}"
            )
        for small, large in (("physics_s", "social_s"), ("social_s", "decision_s")):
            ratio = getattr(self, large) / getattr(self, small)
            if ratio < 1.0 or abs(ratio - round(ratio)) > 1e-9:
                given = f"{getattr(self, large)} / {getattr(self, small)}"
                raise ValueError(f"{small} must divide {large} exactly, given {given}")
        return self

    @property
    def physics_per_social(self) -> int:
        """Physics steps in a social period."""
        return round(self.social_s / self.physics_s)

    @property
    def social_per_decision(self) -> int:
        """Social periods in a decision period."""
        return round(self.decision_s / self.social_s)


class Drive(Section):
    """Drive: slew limits, tracking law and wheel loops (the paper's lower layers)."""

    # v_nom, action +1 (paper); observed speeds end at 1 m/s, contacts are looked for up to 2 m/s
    nominal_speed_mps: Annotated[float, Gt(0), Le(1)] = 0.5
    start_speed_mps: Annotated[float, Ge(0)] = 0.0  # of robot and reference at reset
    acceleration_mps2: Annotated[float, Gt(0)] = 0.5  # slew limit of the command
    deceleration_mps2: Annotated[float, Gt(0)] = 1.0
    latency_steps: Annotated[int, Ge(0), Le(50)] = 0  # latency of commands in decisions
    reflex_stop_m: Annotated[float, Ge(0)] = 0.0  # front range of the reflex stop, 0 = off
    line_sensor: LineSensor = LineSensor()  # line sensor; pitch 0: exact cross-track error
    wheel_loop: Literal["fuzzy_pid", "pid", "ideal"] = "fuzzy_pid"  # ideal: exactly as commanded
    plant: Literal["A", "B", "A0", "C"] | Plant = "A"  # motors (core/pid.py), by name or in full
    tables: Literal["textbook", "symmetric"] = "textbook"  # rules of the fuzzy-PID
    chassis: Chassis = Chassis()
    tracking: TrackingGains = TrackingGains()
    pid: PidGains = PidGains()
    fuzzy: FuzzyPid = FuzzyPid()
    wheel_noise_radps: Annotated[float, Ge(0)] = 0.01  # half width, uniform
    heading_noise_rad: Annotated[float, Ge(0)] = 0.002  # half width, uniform

    @model_validator(mode="after")
    def _start_is_not_faster_than_nominal(self) -> Drive:
        if self.start_speed_mps > self.nominal_speed_mps:
            raise ValueError(
                f"start_speed_mps = {self.start_speed_mps} is above nominal_speed_mps = "
                f"{self.nominal_speed_mps}"
            )
        return self


class Walker(Section):
    """A scripted person who walks straight on at a constant velocity."""

    x_m: float
    y_m: float
    vx_mps: float
    vy_mps: float


class Speeds(NamedTuple):
    """Distribution of walking speeds: normal, truncated to 0.5 to 2.2 m/s."""

    mean_mps: Annotated[float, Gt(0)] = 1.34  # HM95; medians of the real tracks: 1.06 to 1.41
    sd_mps: Annotated[float, Ge(0)] = 0.26  # HM95; real tracks: 0.17 to 0.26
    leader_low_mps: Annotated[float, Gt(0)] = 0.15  # leaders walk slower than the robot,
    leader_high_mps: Annotated[float, Gt(0)] = 0.45  # so that it reaches them


class People(Section):
    """People: patterns, numbers, models and reactions."""

    model: Literal["scripted", "social_force", "replay", "seeded"] = "social_force"
    family: Family = "mixed"  # pattern of the first person
    count: Annotated[tuple[Count, Count], Loose] = (2, 5)  # fewest, most
    mix: Weights = (0.25, 0.35, 0.2, 0.2)  # others' patterns
    speeds: Speeds = Speeds()
    force: SocialForce = SocialForce()
    reactions: Reactions = (ATTENTIVE, INATTENTIVE, WARY, CURIOUS)
    reaction_shares: Weights = (0.6, 0.2, 0.1, 0.1)
    # if given, exactly these people instead of drawn ones
    walkers: Annotated[tuple[Walker, ...], Loose, MaxLen(MOST_PEOPLE)] = ()

    @model_validator(mode="after")
    def _is_possible(self) -> People:
        if self.count[0] > self.count[1]:
            raise ValueError(f"count: given {self.count}, the first must not exceed the second")
        if self.walkers and self.model in ("replay", "seeded"):
            raise ValueError(f"walkers: given, but the model {self.model!r} takes recorded people")
        for name in ("mix", "reaction_shares"):
            if sum(getattr(self, name)) <= 0.0:
                raise ValueError(f"{name}: given {getattr(self, name)}, one weight must exceed 0")
        return self


class Tracker(NamedTuple):
    """People tracker; a person behind a wall or out of range is not reported."""

    range_m: Annotated[float, Gt(0)] = 8.0  # our choice
    position_noise_m: Annotated[float, Ge(0)] = 0.03  # half width, as the range noise of Table 2
    velocity_noise_mps: Annotated[float, Ge(0)] = 0.05  # half width, our choice
    dropout: Annotated[float, Ge(0), Le(1)] = 0.0  # probability of a missed detection per decision
    latency_steps: Annotated[int, Ge(0), Le(50)] = 0  # latency in decisions
    # Slower people count as standing; with the track counts' 0.3 m/s most leaders would.
    moving_mps: Annotated[float, Ge(0)] = 0.1


class Sensors(Section):
    """Sensors of the robot."""

    ultrasonic: Ultrasonic = Ultrasonic()
    tracker: Tracker = Tracker()


class RewardWeights(NamedTuple):
    """Weights of the reward terms of ``task/reward.py``; penalties are negative."""

    progress: float = 1.0
    intrusion: float = -4.0
    tracking: float = -0.5
    smoothness: float = -0.5
    burden: float = -0.1
    contact: float = -200.0
    arrival: float = 60.0


class Config(Section):
    """Configuration of the whole problem."""

    place: str = "corridor"  # a name of task/places.py, or a YAML file
    place_options: dict[str, float] = {}  # lengths of a built-in place [m]
    tracks: str | None = None  # file or folder of recorded people, for replay and seeded
    tier: Literal["sonar", "tracks", "privileged"] = "tracks"
    action_type: Literal["continuous", "discrete"] = "continuous"
    max_episode_steps: Annotated[int, Gt(0), Le(MOST_STEPS)] = 600
    arrival_tolerance_m: Annotated[float, Gt(0)] = 0.05  # distance from the path's end that counts
    clock: Clock = Clock()
    drive: Drive = Drive()
    people: People = People()
    sensors: Sensors = Sensors()
    reward: RewardWeights = RewardWeights()


def merge(base: Mapping[str, object], deltas: Mapping[str, object]) -> JsonObject:
    """Return ``base`` with ``deltas`` laid over it, section by section.

    Raises:
        InvalidInput: Deltas change a part of a value that ``base`` gives by name, or as a list.
    """
    merged = dict(base)
    for key, value in deltas.items():
        below = merged.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            value = merge(below, value)
        elif isinstance(value, Mapping) and len(value) < _parts(below):
            raise InvalidInput(
                f"{_name(key)}: given a part, {_shown(dict(value))}, of {_shown(below)}; allowed "
                f"are all {_parts(below)} values"
            )
        merged[key] = value
    return merged


def _parts(below: object) -> int:
    """Return the number of values of a mapping that replaces a name or list."""
    if isinstance(below, str):
        return len(PLANTS.get(below, ()))
    return len(below) if isinstance(below, list | tuple) else 0


def _paper_scenario(x_m: float, y_m: float, vx_mps: float, vy_mps: float) -> dict[str, object]:
    """Return a scenario of the paper: one scripted walker, an ideal drive already at speed."""
    walker = {"x_m": x_m, "y_m": y_m, "vx_mps": vx_mps, "vy_mps": vy_mps}
    return {
        "place": "open",
        "people": {"model": "scripted", "walkers": [walker]},
        "drive": {"wheel_loop": "ideal", "start_speed_mps": 0.5},
        "sensors": {
            "ultrasonic": {"noise_m": 0.0},
            "tracker": {"position_noise_m": 0.0, "velocity_noise_mps": 0.0},
        },
    }


# The paper's circle (Table 3): at rest at its lowest point, the reference at full speed at once.
# Plant B gives the fuzzy-PID's published figures.
_CIRCLE = {
    "place": "circle",
    "people": {"count": [0, 0]},
    "drive": {
        "plant": "B",
        "acceleration_mps2": 1e9,
        "deceleration_mps2": 1e9,
        "wheel_noise_radps": 0.0,
        "heading_noise_rad": 0.0,
    },
}

# A person walks in the opposite direction beside the circle; the position is our choice.
_HUMAN_ON_THE_WAY = {
    "max_episode_steps": 800,
    "people": {
        "model": "scripted",
        "count": [1, 1],
        "walkers": [{"x_m": 4.7, "y_m": 9.8, "vx_mps": 0.0, "vy_mps": -0.5}],
    },
    "drive": {
        "acceleration_mps2": 0.5,
        "deceleration_mps2": 1.0,
        "wheel_noise_radps": 0.01,
        "heading_noise_rad": 0.002,
    },
}

_AS_BUILT = {  # realistic drive, and a robot that starts with the people
    "drive": {"wheel_loop": "fuzzy_pid", "plant": "B", "start_speed_mps": 0.0},
    "sensors": {
        "ultrasonic": {"noise_m": 0.03},
        "tracker": {"position_noise_m": 0.03, "velocity_noise_mps": 0.05},
    },
}

# The front wall of the crossing experiment; its position is not printed.
_FRONT_WALL = {
    "place_options": {"length_m": 8.0, "end_wall_m": 0.35},
    "drive": {"reflex_stop_m": 0.5},
}

_C_STAR_RAD = math.radians(-66.9)
_E_STAR = _paper_scenario(4.479, 0.800, -0.5, 0.0)
_E_FAR = _paper_scenario(5.442, 0.800, -0.5, 0.0)
_C_STAR = _paper_scenario(2.750, 4.763, 0.5 * math.cos(_C_STAR_RAD), 0.5 * math.sin(_C_STAR_RAD))
SCENARIOS: dict[str, JsonObject] = {
    "E*": _E_STAR,  # encountering, the simulation
    "E5.5": _E_FAR,  # encountering, the experiment's distance
    "C*": _C_STAR,  # crossing
    "C90": _paper_scenario(3.889, 3.889, 0.0, -0.5),  # crossing at a right angle
    "E-experiment": merge(_E_FAR, _AS_BUILT),
    "C-experiment": merge(_C_STAR, _AS_BUILT),
    "C-experiment+wall": merge(merge(_C_STAR, _AS_BUILT), _FRONT_WALL),
    "circle": _CIRCLE,  # nobody there
    "circle+human": merge(_CIRCLE, _HUMAN_ON_THE_WAY),  # the paper's Figure 19
}


def make_config(
    given: Config | Mapping[str, object] | str | Path | None = None,
    /,
    *,
    preset: Mapping[str, object] | None = None,
    scenario: str | None = None,
    **overrides: object,
) -> Config:
    """Return a validated config: defaults, then preset, named scenario, ``given``, and overrides.

    Args:
        given: A config, a mapping of deltas, or the path of a YAML file of deltas.
        preset: Deltas of a registered environment.
        scenario: A name of ``SCENARIOS``.
        **overrides: Fields of ``Config``; sections as mappings of deltas.

    Raises:
        InvalidInput: One line that names the field, what was given and what is allowed.
        UnknownKeyword: The same, where an override is no field.
    """
    if not isinstance(preset, Mapping | None):
        raise InvalidInput(f"preset: given {preset!r}, allowed is a mapping")
    if scenario is not None and not (isinstance(scenario, str) and scenario in SCENARIOS):
        raise InvalidInput(f"scenario: given {scenario!r}, allowed are {', '.join(SCENARIOS)}")
    for name in overrides.keys() - Config.model_fields.keys():
        raise UnknownKeyword(
            f"{_name(name)}: unknown key, allowed are {', '.join(Config.model_fields)} "
            f"(unexpected keyword argument {name!r})"
        )
    deltas: dict[str, object] = {}
    for layer in (preset or {}, SCENARIOS[scenario] if scenario else {}, _deltas(given), overrides):
        deltas = merge(deltas, layer)
    try:
        return Config.model_validate(plain(deltas))
    except ValidationError as error:
        raise InvalidInput(first_error(error)) from error


def horizon_in(
    given: Config | Mapping[str, object] | str | Path | None, scenario: object
) -> object:
    """Return the ``max_episode_steps`` of a config, else of a named scenario; or None."""
    named = SCENARIOS.get(scenario, {}) if isinstance(scenario, str) else {}
    return {**named, **_deltas(given)}.get("max_episode_steps")


def _deltas(given: Config | Mapping[str, object] | str | Path | None) -> Mapping[str, object]:
    """Return the argument of ``make_config`` as a mapping."""
    if isinstance(given, Config):
        return dict(_as_mappings(given))
    if isinstance(given, str | Path):
        return read_yaml(Path(given))
    if given is not None and not isinstance(given, Mapping):
        kind = type(given).__name__
        raise InvalidInput(f"config: given {kind}, allowed are a Config, a mapping or a path")
    return given or {}


def plain(value: Any) -> Any:
    """Return deltas with NumPy values converted to Python's."""
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if type(value) in (list, tuple):
        return [plain(each) for each in value]
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def first_error(error: ValidationError, model: type[BaseModel] = Config) -> str:
    """Return pydantic's first error as one line: field, given and allowed value."""
    # Of a union's errors, the deepest refers to the intended alternative.
    first = max(error.errors(include_url=False), key=lambda each: len(each["loc"]))
    # Without the alternatives of a union, such as literal['A', 'B'].
    location = [_name(part) for part in first["loc"] if "[" not in str(part)]
    field = ".".join(location) or "config"
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        return f"{field}: {message.removeprefix('env: ')}"
    if first["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
        return f"{field}: unknown key{_known_keys(first['loc'], model)}"
    return f"{field}: given {_shown(first['input'])}, {message[0].lower()}{message[1:]}"


def _name(field: int | str) -> str:
    """Return the name of a field on one line."""
    return repr(field).strip("'")


def _shown(value: object) -> str:
    """Return the repr of a value, shortened."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no integers of more than 4300 digits
        return "a number of thousands of digits"
    return text if len(text) <= 120 else f"{text[:117]}..."


def _known_keys(location: tuple[int | str, ...], model: type[BaseModel]) -> str:
    """Return the allowed keys at the location of an unknown key, if known."""
    node: object = model
    for part in location[:-1]:
        if isinstance(part, int):
            node = next(iter(get_args(node)), None)
        else:
            known = getattr(node, "model_fields", {}).get(part)
            node = known.annotation if known else None
    keys = getattr(node, "model_fields", None) or getattr(node, "_fields", ())
    return f", allowed are {', '.join(keys)}" if keys else ""


def _as_mappings(value: object) -> Any:
    """Return a section and its named tuples as mappings, for merging."""
    if isinstance(value, Section):
        return {name: _as_mappings(getattr(value, name)) for name in type(value).model_fields}
    return value._asdict() if hasattr(value, "_asdict") else value
