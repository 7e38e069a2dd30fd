"""A run as messages: the scene that stays, and frames of what moves."""

from __future__ import annotations

import base64
import math

import numpy as np
import numpy.typing as npt

from hazbot_gym import __version__
from hazbot_gym.core.geometry import path_length, sample_path
from hazbot_gym.core.proxemics import INTIMATE_M, PERSONAL_M, SOCIAL_M
from hazbot_gym.core.sensor_ring import half_cone_of, sensors_of
from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M, Floats
from hazbot_gym.envs.plume import CELL_M, PlumeGrid, gas_frame_of
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.evaluation.metrics import HEADLINE, measure
from hazbot_gym.live import messages
from hazbot_gym.live.policies import Policies
from hazbot_gym.live.run import Run
from hazbot_gym.live.settings import ENVS, PAPER, Settings, default_config, default_width_m
from hazbot_gym.policies.fuzzy_expert import DISTANCE_TERMS, KEPT_TERMS, SPEED_TERMS, FuzzyExpert
from hazbot_gym.policies.fuzzy_trace import PersonTrace, trace
from hazbot_gym.task.leak import leak_point
from hazbot_gym.task.observation import layout_in

DIGITS = 4  # of what is sent
STEP_M = 0.1  # distance of the points of the path
MARGIN_M, OPEN_MARGIN_M = 1.8, 2.6  # of the box around it, and of a place without walls
COARSE = 2  # every second cell of the gas is sent,
PLUME_EVERY = 5  # with every fifth decision
WIDE = 1e6  # instead of the infinite width of a shoulder
BLIND = 1  # row of the reactions: does not yield


def hello(policies: Policies) -> messages.Hello:
    """Return the choices of the page."""
    return messages.Hello(
        version=__version__,
        places=tuple(_place(name) for name in (*ENVS, *PAPER)),
        policies=policies.choices(),
        distance_terms=_terms(DISTANCE_TERMS),
        speed_terms=_terms(SPEED_TERMS),
        kept=KEPT_TERMS,
    )


def _terms(terms: dict[str, tuple[float, float, float]]) -> dict[str, messages.Term]:
    """Return fuzzy terms: centre and widths, of which JSON has no infinite ones."""
    return {
        name: (c, min(left, WIDE), min(right, WIDE)) for name, (c, left, right) in terms.items()
    }


def _place(name: str) -> messages.Choice:
    config = default_config(name)
    shares = config.people.reaction_shares
    return messages.Choice(
        name=name,
        label=f"The paper's {name}" if name in PAPER else name.rsplit("-v", 1)[0],
        about="one person, as published" if name in PAPER else ENVIRONMENTS[name][0],
        has_gas=config.gas is not None,
        width_m=default_width_m(config),
        people=(1, 1) if name in PAPER else config.people.count,
        unyielding=shares[BLIND] / sum(shares),
    )


def scene_of(
    run: Run, settings: Settings, grid: PlumeGrid | None, policy: str | None = None
) -> messages.Scene:
    """Return the fixed part of a run."""
    env, config = run.env, run.env.episode_config
    place, sonar = env.world.place, config.sensors.ultrasonic
    length = path_length(place.path.view(np.recarray))
    path = sample_path(place.path, np.linspace(0.0, length, math.ceil(length / STEP_M) + 1))[:, :2]
    margin_m = MARGIN_M if len(place.walls) else OPEN_MARGIN_M
    low, high = path.min(axis=0) - margin_m, path.max(axis=0) + margin_m
    layout = layout_in(config)
    return messages.Scene(
        settings=settings,
        key=str(run.info["scenario_key"]),
        command=settings.command(policy),
        decision_s=config.clock.decision_s,
        horizon_s=config.max_episode_steps * config.clock.decision_s,
        time_free_s=run.info["time_free_s"],
        top_speed_mps=config.drive.nominal_speed_mps,
        walls=_rounded(place.walls),
        path=_rounded(path),
        box=tuple(np.concatenate([low, high]).round(DIGITS).tolist()),
        zones_m=(SOCIAL_M, PERSONAL_M, INTIMATE_M),
        robot_m=ROBOT_RADIUS_M,
        person_m=PERSON_RADIUS_M,
        sonar_m=(sonar.mount_radius_m, sonar.range_m),
        sensors=tuple(
            messages.Sensor(
                name=each.name,
                angle_rad=each.angle_rad,
                half_rad=half_cone_of(each, sonar.half_cone_rad),
            )
            for each in sensors_of(config.sensors.ring)
        ),
        fields=tuple(
            messages.FieldOf(
                name=each.name, unit=each.unit, low=each.low, high=each.high, meaning=each.meaning
            )
            for each in layout.fields
        ),
        weights=dict(zip(run.info["reward_terms"], run.weights.tolist(), strict=True)),
        leak=tuple(leak_point(place, run.now.gas).round(DIGITS).tolist()),
        plume=None if grid is None else _plume(run, grid),
    )


def frame_of(
    run: Run,
    expert: ExpertView,
    ghost: messages.Ghost | None,
    grid: PlumeGrid | None,
) -> messages.Frame:
    """Return the present instant of a run."""
    now, info = run.now, run.info
    layout = layout_in(run.env.episode_config)
    seen = layout.decode(run.observation)
    terms = run.weights * np.array([*info["reward_terms"].values()])
    gas = now.gas
    return messages.Frame(
        decision=run.decision,
        time_s=now.time_s,
        pose=_floats([now.x, now.y, now.theta]),
        speed=_float(now.speed_mps),
        command=_float(now.command_mps),
        people=_people(run),
        ranges=_floats([seen[name] for name in layout.names[: len(layout.sensors)]]),
        observation=_floats([seen[name] for name in layout.names]),
        terms=_floats(terms),
        totals=_floats(run.totals),
        expert_share=_float(expert.share),
        expert=tuple(_concluded(each) for each in expert.people),
        outcome=info["outcome"],
        caused_by=info["contact_caused_by"],
        is_edited=run.is_edited,
        ghost=ghost,
        reading=_float(gas["smell"]["reading"][0]) if len(gas) else None,
        plume=None if grid is None or run.decision % PLUME_EVERY else _cells(run, grid),
        results=results_of(run) if run.is_over else None,
    )


def ghost_of(run: Run, policy: str) -> messages.Ghost:
    """Return the second policy's instant."""
    now = run.now
    return messages.Ghost(
        policy=policy,
        pose=_floats([now.x, now.y, now.theta]),
        speed=_float(now.speed_mps),
        earned=_float(run.totals.sum()),
        outcome=run.info["outcome"],
        time_s=now.time_s,
    )


def results_of(run: Run) -> dict[str, float]:
    """Return the headline metrics of a run that is over."""
    row = measure(run.episode())
    numbers = {name: float(row[name]) for name in ("time_s", *HEADLINE) if name in row}
    return {name: round(value, DIGITS) for name, value in numbers.items() if math.isfinite(value)}


class ExpertView:
    """The fuzzy expert's conclusions, whoever drives.

    Attributes:
        share: The expert's speed factor.
        people: Its conclusions from each person.
    """

    def __init__(self) -> None:
        self._expert = FuzzyExpert()
        self._state: object = None
        self._starts = np.array([True])
        self.share, self.people = 1.0, list[PersonTrace]()

    def see(self, run: Run) -> None:
        """Take the next observation, each only once: the sonar's estimates have a memory."""
        full, self._state = self._expert.with_estimates(run.observation, self._state, self._starts)
        self._starts = np.array([False])
        self.share = _float(np.asarray(self._expert.speed_share(full)))
        self.people = trace(self._expert, full)


def grid_of(run: Run) -> PlumeGrid | None:
    """Return the grid of a run's gas, None without a leak."""
    gas = run.now.gas
    if not len(gas) or gas["leak"]["is_there"][0] == 0:
        return None
    leak = gas["leak"][0]
    return PlumeGrid(run.env.world.place, leak["left_m"], leak["right_m"])


def _plume(run: Run, grid: PlumeGrid) -> messages.Plume:
    rows, columns = _opacity(run, grid).shape
    return messages.Plume(
        left_m=grid.left_m, top_m=grid.top_m, cell_m=COARSE * CELL_M, columns=columns, rows=rows
    )


def _cells(run: Run, grid: PlumeGrid) -> str:
    return base64.b64encode(_opacity(run, grid).tobytes()).decode()


def _opacity(run: Run, grid: PlumeGrid) -> npt.NDArray[np.uint8]:
    gas = gas_frame_of(run.env.episode_config, run.now.gas, run.info["scenario_key"])
    assert gas is not None
    return np.ascontiguousarray(grid.opacity(gas, run.now.time_s)[::COARSE, ::COARSE])


def _people(run: Run) -> tuple[messages.Person, ...]:
    patterns, led = run.env.tracks["pattern"], run.led
    return tuple(
        messages.Person(
            index=int(index),
            x=_float(person["x"]),
            y=_float(person["y"]),
            vx=_float(person["vx"]),
            vy=_float(person["vy"]),
            pattern=int(patterns[index]),
            reaction=int(person["reaction"]),
            is_led=int(index) in led,
        )
        for index, person in zip(run.now.persons, run.now.people, strict=True)
    )


def _concluded(person: PersonTrace) -> messages.Concluded:
    return messages.Concluded(
        distance_m=_float(person.distance_m),
        speed_mps=_float(person.speed_mps),
        pattern=person.pattern,
        distance={name: _float(value) for name, value in person.distance.items()},
        speed={name: _float(value) for name, value in person.speed.items()},
        rules=tuple(
            messages.Rule(terms=rule[:4], weight=_float(rule.weight)) for rule in person.rules
        ),
        kept=_float(person.kept),
    )


def _float(value: npt.ArrayLike) -> float:
    return round(float(np.asarray(value)), DIGITS)


def _floats(values: npt.ArrayLike) -> tuple[float, ...]:
    return tuple(np.asarray(values, np.float64).round(DIGITS).tolist())


def _rounded(points: Floats) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in np.asarray(points).round(DIGITS).tolist())
