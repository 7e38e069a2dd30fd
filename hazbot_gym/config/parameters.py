"""Parameters of the whole problem, with units. Those of an equation live beside it in ``core``."""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple

from annotated_types import Ge, Gt, Le, MaxLen
from pydantic import AfterValidator, Field, model_validator

from hazbot_gym.config.section import Loose, Section
from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.gas import Plume
from hazbot_gym.core.gas_sensor import GasSensorChoice
from hazbot_gym.core.kinematics import Chassis
from hazbot_gym.core.line_sensor import LineSensor
from hazbot_gym.core.own_terms import check_terms
from hazbot_gym.core.own_walking import check_model
from hazbot_gym.core.pid import PidGains, Plant
from hazbot_gym.core.sensor_ring import (
    RangeSensor,
    check_ring,
    is_ahead,
    sensors_of,
)
from hazbot_gym.core.social_force import (
    ATTENTIVE,
    BLIND,
    CURIOUS,
    WARY,
    Reaction,
    SocialForce,
)
from hazbot_gym.core.state import FASTEST_NOMINAL_MPS, PERSON_SLOTS
from hazbot_gym.core.tracking import TrackingGains
from hazbot_gym.core.ultrasonic import Ultrasonic
from hazbot_gym.utils.json_object import JsonObject

Family = Literal["crossing", "encountering", "leading", "confronting", "mixed"]

MOST_PEOPLE = 64
MOST_STEPS = 100_000  # of an episode: nearly three hours
MOST_PHYSICS_STEPS = 1000  # of a decision

Count = Annotated[int, Ge(0), Le(MOST_PEOPLE)]
Weight = Annotated[float, Ge(0)]
Positive = Annotated[float, Gt(0)]
NominalSpeed = Annotated[float, Gt(0), Le(FASTEST_NOMINAL_MPS)]
Draught = Annotated[float, Gt(0), Le(10)]
Weights = Annotated[tuple[Weight, Weight, Weight, Weight], Loose]
Reactions = Annotated[tuple[Reaction, Reaction, Reaction, Reaction], Loose]


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

    nominal_speed_mps: NominalSpeed = 0.5  # v_nom, action +1 (paper)
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

    # scripted, social_force, replay, seeded, or one of your own (docs/own_people.md)
    model: Annotated[str, AfterValidator(check_model)] = "social_force"
    family: Family = "mixed"  # pattern of the first person
    count: Annotated[tuple[Count, Count], Loose] = (2, 5)  # fewest, most
    mix: Weights = (0.25, 0.35, 0.2, 0.2)  # others' patterns
    # Times at which people cross, relative to the arrival of a robot at nominal speed
    crossing_window_s: Annotated[tuple[float, float], Loose] = (-3.0, 4.0)
    speeds: Speeds = Speeds()
    force: SocialForce = SocialForce()
    reactions: Reactions = (ATTENTIVE, BLIND, WARY, CURIOUS)
    reaction_shares: Weights = (0.7, 0.3, 0.0, 0.0)
    # if given, exactly these people instead of drawn ones
    walkers: Annotated[tuple[Walker, ...], Loose, MaxLen(MOST_PEOPLE)] = ()

    @model_validator(mode="after")
    def _is_possible(self) -> People:
        if self.count[0] > self.count[1]:
            raise ValueError(f"count: given {self.count}, the first must not exceed the second")
        if self.walkers and self.model in ("replay", "seeded"):
            raise ValueError(f"walkers: given, but the model {self.model!r} takes recorded people")
        if self.crossing_window_s[0] > self.crossing_window_s[1]:
            raise ValueError(
                f"crossing_window_s: given {self.crossing_window_s}, the first must not exceed the "
                "second"
            )
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

    # range sensors and where they point (core/sensor_ring.py), by name or in full
    ring: Annotated[
        Literal["paper", "six"] | Annotated[tuple[RangeSensor, ...], Loose],
        AfterValidator(check_ring),
    ] = "paper"
    ultrasonic: Ultrasonic = Ultrasonic()
    tracker: Tracker = Tracker()


class Gas(Section):
    """Gas: a leak somewhere along the path, its plume, and the sensor that the robot carries."""

    # core/gas_sensor.py, by name or in full
    sensor: GasSensorChoice = "TGS2611"
    leak_share: Annotated[float, Ge(0), Le(1)] = 0.7  # share of episodes with a leak
    # Lowest and highest, our choice: from leaks that are missed to leaks that no one misses
    strength_ppm: Annotated[tuple[Positive, Positive], Loose] = (5.0, 50.0)  # 1 m downwind
    draught_mps: Annotated[tuple[Draught, Draught], Loose] = (0.2, 0.5)  # in either direction
    plume: Plume = Plume()

    @model_validator(mode="after")
    def _ranges_ascend(self) -> Gas:
        for name in ("strength_ppm", "draught_mps"):
            low, high = getattr(self, name)
            if low > high:
                given = getattr(self, name)
                raise ValueError(f"{name}: given {given}, the first must not exceed the second")
        return self


class RewardWeights(NamedTuple):
    """Weights of the reward terms of ``task/reward.py``; penalties are negative."""

    progress: float = 1.0
    intrusion: float = -0.4  # 4 s of delay per second of full discomfort (docs/encounters.md)
    tracking: float = -0.5
    smoothness: float = -0.5
    burden: float = -0.1  # a second of a person's delay costs as much as one of the robot's
    contact: float = -400.0  # more than blocking a person until the horizon
    arrival: float = 1.0  # per second
    survey: float = 150.0  # only with gas: a leak missed costs 300 s more than a leak found


class Config(Section):
    """Configuration of the whole problem."""

    place: str = "corridor"  # a name of task/places.py, or a YAML file
    place_options: dict[str, float] = Field(default_factory=dict)  # lengths of a built-in place [m]
    tracks: str | None = None  # file or folder of recorded people, for replay and seeded
    tier: Literal["sonar", "tracks", "privileged"] = "tracks"
    # nearest people in the observation (docs/own_observation.md)
    person_slots: Annotated[int, Ge(1), Le(MOST_PEOPLE)] = PERSON_SLOTS
    action_type: Literal["continuous", "discrete"] = "continuous"
    max_episode_steps: Annotated[int, Gt(0), Le(MOST_STEPS)] = 1200
    arrival_tolerance_m: Annotated[float, Gt(0)] = 0.05  # distance from the path's end that counts
    nearness: Literal["discomfort", "depth"] = "discomfort"  # in the reward (task/reward.py)
    clock: Clock = Clock()
    drive: Drive = Drive()
    people: People = People()
    sensors: Sensors = Sensors()
    gas: Gas | None = None  # given, even if empty: gas, a gas sensor, and a reward for leaks found
    reward: RewardWeights = RewardWeights()
    # weights of reward terms of your own, by name (docs/own_reward.md)
    own_terms: Annotated[dict[str, float], AfterValidator(check_terms)] = Field(
        default_factory=dict
    )
    # distributions of values that are drawn for each episode, by dotted name (docs/randomise.md);
    # usually given in place of the values
    randomised: dict[str, JsonObject] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _own_terms_have_own_names(self) -> Config:
        for name in self.own_terms.keys() & set(RewardWeights._fields):
            raise ValueError(f"own_terms: given {name!r}, which is a term of reward")
        return self

    @model_validator(mode="after")
    def _reflex_has_a_sensor_ahead(self) -> Config:
        if self.drive.reflex_stop_m > 0.0 and not any(map(is_ahead, sensors_of(self.sensors.ring))):
            raise ValueError(
                f"drive.reflex_stop_m: given {self.drive.reflex_stop_m}, but no sensor of "
                "sensors.ring points ahead; allowed is 0"
            )
        return self
