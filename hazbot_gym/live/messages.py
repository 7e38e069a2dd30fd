"""Messages between the page and the server, as JSON; both ways they are checked."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Le, MaxLen
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from hazbot_gym.config.section import Section, shown
from hazbot_gym.errors import InvalidInput
from hazbot_gym.live.settings import Settings

Coordinate = Annotated[float, Ge(-1000), Le(1000)]
Index = Annotated[int, Ge(0), Le(1000)]
RATES = (0.25, 0.5, 1.0, 2.0, 4.0)  # of the playback, relative to real time
MOST_BYTES = 1_000_000  # of a message; a recorded run of 1200 decisions has some 30,000

# --- from the page --------------------------------------------------------------------------------


class Configure(Section):
    """Other settings; other policies swap in mid-run, anything else starts the run anew."""

    kind: Literal["configure"] = "configure"
    settings: Settings


class Play(Section):
    """Play or pause, and how fast."""

    kind: Literal["play"] = "play"
    is_playing: bool
    rate: Annotated[float, Ge(RATES[0]), Le(RATES[-1])] = 1.0


class Step(Section):
    """Take one decision."""

    kind: Literal["step"] = "step"


class Restart(Section):
    """Start anew in the same, the next or the last scenario."""

    kind: Literal["restart"] = "restart"
    by: Annotated[int, Ge(-1), Le(1)] = 0


class Throttle(Section):
    """The speed that a person at the page commands, as a share of the nominal speed."""

    kind: Literal["throttle"] = "throttle"
    share: Annotated[float, Ge(0), Le(1)]


class Hold(Section):
    """Lead a person towards a point until let go."""

    kind: Literal["hold"] = "hold"
    person: Index
    x_m: Coordinate
    y_m: Coordinate


class LetGo(Section):
    """Let a person go."""

    kind: Literal["let_go"] = "let_go"
    person: Index


class AddPerson(Section):
    """Add a person at a point."""

    kind: Literal["add"] = "add"
    x_m: Coordinate
    y_m: Coordinate


class RemovePerson(Section):
    """Remove a person."""

    kind: Literal["remove"] = "remove"
    person: Index


class Export(Section):
    """Send a file: the scene as YAML, or the run."""

    kind: Literal["export"] = "export"
    what: Literal["scene", "run"]


class Load(Section):
    """Play a recorded run."""

    kind: Literal["load"] = "load"
    text: Annotated[str, MaxLen(MOST_BYTES)]


class Compare(Section):
    """Measure the expert and the learned policy in the ten scenarios."""

    kind: Literal["compare"] = "compare"


Received = Annotated[
    Configure
    | Play
    | Step
    | Restart
    | Throttle
    | Hold
    | LetGo
    | AddPerson
    | RemovePerson
    | Export
    | Load
    | Compare,
    Field(discriminator="kind"),
]
_RECEIVED: TypeAdapter[Received] = TypeAdapter(Received)


def parse(text: str) -> Received:
    """Return a message of the page.

    Raises:
        InvalidInput: It is none; one line says why.
    """
    try:
        return _RECEIVED.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "message"
        what = first["msg"].removeprefix("Value error, ")
        raise InvalidInput(f"{where}: given {shown(first['input'])}: {what}") from None


# --- to the page ----------------------------------------------------------------------------------


class Message(BaseModel):
    """A message to the page, or a part of one: finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Choice(Message):
    """A choice of the page: a place or a policy."""

    name: str
    label: str
    about: str
    has_gas: bool = False  # a place with gas, or a policy for these
    prices: tuple[float, float, float] | None = None  # least, most and usual one of a policy
    width_m: float | None = None  # of a place, if it can be set
    people: tuple[int, int] = (0, 0)  # fewest and most of a place
    unyielding: float = 0.0  # their share in a place


Term = tuple[float, float, float]  # centre, width left and width right of a fuzzy term


class Hello(Message):
    """First message: what there is to choose from."""

    kind: Literal["hello"] = "hello"
    version: str
    places: tuple[Choice, ...]
    policies: tuple[Choice, ...]
    rates: tuple[float, ...] = RATES
    distance_terms: dict[str, Term]  # of the fuzzy expert
    speed_terms: dict[str, Term]
    kept: dict[str, float]  # speed factor of each of its outputs


class FieldOf(Message):
    """A field of the observation."""

    name: str
    unit: str
    low: float
    high: float
    meaning: str


class Sensor(Message):
    """A range sensor: where it points, and half its cone [rad]."""

    name: str
    angle_rad: float
    half_rad: float


class Plume(Message):
    """The grid of the gas: its upper left corner, cells and size [m]."""

    left_m: float
    top_m: float
    cell_m: float
    columns: int
    rows: int


class Scene(Message):
    """A run begins: everything that does not change until it is over."""

    kind: Literal["scene"] = "scene"
    settings: Settings
    key: str  # of the scenario; a browser has no integers of 63 bits
    command: str  # that measures the same
    decision_s: float
    horizon_s: float
    time_free_s: float
    top_speed_mps: float
    walls: tuple[tuple[float, float, float, float], ...]
    path: tuple[tuple[float, float], ...]
    box: tuple[float, float, float, float]  # left, bottom, right, top [m]
    zones_m: tuple[float, float, float]  # social, personal, intimate
    robot_m: float
    person_m: float
    sonar_m: tuple[float, float]  # mount radius, range
    sensors: tuple[Sensor, ...]
    fields: tuple[FieldOf, ...]
    weights: dict[str, float]  # of the reward terms
    leak: tuple[float, ...]  # x, y, or nothing
    plume: Plume | None


class Person(Message):
    """A person who is present."""

    index: int
    x: float
    y: float
    vx: float
    vy: float
    pattern: int
    reaction: int
    is_led: bool


class Rule(Message):
    """A rule of the fuzzy expert that fires."""

    terms: tuple[str, str, str, str]
    weight: float


class Concluded(Message):
    """Conclusions of the fuzzy expert from one person."""

    distance_m: float
    speed_mps: float
    pattern: str
    distance: dict[str, float]
    speed: dict[str, float]
    rules: tuple[Rule, ...]
    kept: float


class Ghost(Message):
    """The second policy in its own copy of the scenario."""

    policy: str
    pose: tuple[float, float, float]
    speed: float
    earned: float
    outcome: str
    time_s: float


class Frame(Message):
    """An instant."""

    kind: Literal["frame"] = "frame"
    decision: int
    time_s: float
    pose: tuple[float, float, float]
    speed: float
    command: float
    people: tuple[Person, ...]
    ranges: tuple[float, ...]
    observation: tuple[float, ...]
    terms: tuple[float, ...]  # weighted, of the last decision
    totals: tuple[float, ...]  # the same, summed so far
    expert_share: float
    expert: tuple[Concluded, ...]
    outcome: str
    caused_by: str
    is_edited: bool
    ghost: Ghost | None
    reading: float | None  # of the gas sensor, in units of its alarm threshold
    plume: str | None  # opacities as base64, now and then
    results: dict[str, float] | None  # at the end


class Line(Message):
    """A line to be read: something was refused, or done."""

    kind: Literal["line"] = "line"
    text: str
    is_error: bool = False


class Download(Message):
    """A file to be saved."""

    kind: Literal["download"] = "download"
    name: str
    text: str


class Scores(Message):
    """Return in each of the ten scenarios, None where not driven yet."""

    kind: Literal["scores"] = "scores"
    returns: dict[str, tuple[float | None, ...]]  # by policy; a person at the page is "you"


Sent = Hello | Scene | Frame | Line | Download | Scores
