"""CorridorEnv: composition of scenario, world, sensors, observation and reward."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, SupportsFloat, cast

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.own_walking import check_walk
from hazbot_gym.core.state import NO_CONTACT, TRACK, Records, as_record, records
from hazbot_gym.envs.arguments import (
    Info,
    array_of,
    episode_base,
    options_of,
    overrides_of,
)
from hazbot_gym.envs.spec import CompleteSpec, horizon_given_to_make
from hazbot_gym.envs.viewer import MODES, Viewer
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.perception import (
    blank_tracks,
    nearest_ahead,
    perceive_kernel,
    ring_of,
    sensor_parameters,
    tracker_of,
)
from hazbot_gym.sim.smell import smell_kernel
from hazbot_gym.sim.world import Snapshot, World
from hazbot_gym.task.action import ACTION_TOLERANCE, SPEED_LEVELS, commanded_speed, level_action
from hazbot_gym.task.leak import gas_info
from hazbot_gym.task.observation import layout_in, markdown_table, observe_kernel
from hazbot_gym.task.outcome import CAUSE_NAMES, OUTCOME_NAMES, RUNNING, TIMEOUT
from hazbot_gym.task.randomised import draw_config, most_people
from hazbot_gym.task.reward import (
    judge_kernel,
    own_terms_in,
    safety_cost,
    terms_of,
    weights_of,
)
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.task.step_record import STEP, rules_of
from hazbot_gym.task.survey import survey_kernel
from hazbot_gym.utils.whole_number import whole_number


class CorridorEnv(gymnasium.Env[npt.NDArray[np.float32], Any]):
    """A gas-inspection robot follows a path through a place shared with people; choose its speed.

    ## Description

    A wheeled robot (radius 0.30 m, 34 kg, two driven wheels and a castor) inspects along a given
    path. A tracking controller steers; the agent only chooses the speed, ten times per second.
    People walk in the same place: they cross, pass in the opposite direction, walk ahead, or walk
    straight at the robot. The robot should arrive soon, keep out of people's personal space while
    it moves, and not block their way. The system follows Gao et al. 2022 (Chinese Journal of
    Mechanical Engineering), with corrections.

    ## Action Space

    ``Box(-1, 1, (1,), float32)``: commanded speed, -1 is stop and +1 the nominal 0.5 m/s. With
    ``action_type="discrete"``: ``Discrete(5)``, the paper's stop, 25, 50, 75 and 100 %.

    Actions within 1e-6 of the bounds are clipped to them; NaN and values further out raise
    ``InvalidInput``. ``gymnasium.wrappers.ClipAction`` clips the actions of an unbounded policy,
    ``RescaleAction`` changes the range; ``gymnasium.wrappers.vector`` has both for batches.

    ## Observation Space

    ``Box`` of float32. Values are divided by the scale in the unit column. The tier ``sonar`` has
    only the fields without the prefix ``person``. With gas, the fields of the gas sensor
    (``task/observation.py``) come before those of people.

    {observation_table}

    ## Transition Dynamics

    The command passes a slew limit (+0.5, -1.0 m/s^2); a reference point moves along the path at
    that speed; the tracking law (12c) and fuzzy-PID wheel loops at 100 Hz follow it on mismatched
    motors. People update their velocity every 0.05 s by social forces. Contacts are detected by
    pymunk.

    ## Reward

    A weighted sum of the terms in ``info["reward_terms"]`` (``task/reward.py``); the weights are
    ``config.reward``. ``info["cost"]`` is the safety cost for constrained learning: the intrusion
    term, plus 1 for a robot-caused contact. With gas there is one more term, ``survey``: leaks
    reported and missed, and false alarms. Terms of your own (``own_terms``) come last;
    ``info["own_terms"]`` has their ranges and weights.

    ## Starting State

    The robot is at rest at the start of its path. People are sampled such that they meet the robot;
    the sample is a pure function of a key that ``reset(seed=...)`` draws from ``np_random``. So are
    randomised values of the config, which are in ``info["randomised"]``.

    ## Episode End

    Terminated on arrival and on contact with a person or a wall, truncated after
    ``max_episode_steps``. ``info["outcome"]`` is ``running`` until then, and ``arrived``,
    ``contact_person``, ``contact_wall`` or ``timeout`` at the end. With a contact,
    ``info["contact_caused_by"]`` is ``robot`` or ``person`` instead of ``nobody``, and
    ``info["contact_speed_mps"]`` is the relative speed instead of 0. The keys of ``info`` and their
    types are the same after every reset and step. With gas, ``info["gas"]`` has the true
    concentration, reading and alarm, leak and distance, and what was reported. The horizon is
    ``config.max_episode_steps``, at most 100,000; ``gymnasium.make(id, max_episode_steps=n)`` sets
    it, too.

    ## Arguments

    Fields of ``hazbot_gym.config.Config``, sections as mappings, and ``scenario`` for a named
    scenario:

    >>> import gymnasium, hazbot_gym
    >>> env = gymnasium.make("hazbot_gym/Corridor-v1", tier="sonar", people={{"count": [4, 4]}})
    >>> env.observation_space.shape
    (12,)
    >>> env = gymnasium.make("hazbot_gym/Corridor-v1", scenario="E*")

    ## Version History

    * v1: people as measured in encounters with a robot, a measured price of nearness, people who
      do not yield, and a longer horizon.
    * v0: initial version, not released.
    """

    metadata: dict[str, Any] = {"render_modes": list(MODES), "render_fps": 10}  # noqa: RUF012
    spec = CompleteSpec()

    def __init__(
        self,
        config: Config | Mapping[str, object] | str | Path | None = None,
        *,
        preset: Mapping[str, object] | None = None,
        scenario: str | None = None,
        render_mode: str | None = None,
        **overrides: object,
    ) -> None:
        """Make an environment from a preset, then a named scenario, a config, and single overrides.

        Raises:
            InvalidInput: A value cannot be used; one line says which and what is allowed.
        """
        overrides |= horizon_given_to_make(self)
        self.config = make_config(config, preset=preset, scenario=scenario, **overrides)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": 1.0 / self.config.clock.decision_s}
        self._viewer = Viewer(render_mode, self.config)
        self._term_names = terms_of(self.config)
        self._layout = layout_in(self.config)
        observed, self.action_space = spaces_of(self.config)
        self.observation_space = cast("gymnasium.Space[npt.NDArray[np.float32]]", observed)
        self._terms = np.zeros(len(self._term_names))
        self._record = records(STEP, 1)
        self._is_over = True
        self._prepare(self.config, warns=True)
        most_people(self.config, self.source.people)  # tries all extreme values

    def _prepare(self, config: Config, *, warns: bool = False) -> None:
        """Prepare for episodes with a config; ``warns`` of a doubtful place."""
        self.episode_config = config
        self.source = ScenarioSampler(config, warns=warns)
        self._world = World(config)
        self._sensors = as_record(sensor_parameters(config))
        self._ring = ring_of(config)
        self._ranges = np.zeros(len(self._ring))
        self._weights = weights_of(config)
        self._own_terms = own_terms_in(config)
        self._rules = as_record(rules_of(config))
        self._free_times: dict[bytes, float] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], Info]:
        """Start an episode.

        Args:
            seed: As in Gymnasium.
            options: ``{"key": k}`` for the scenario of that key; ``{"config": {...}}`` for other
                values of the config in this episode.
        """
        checked = options_of(options, "key", "config")
        base = episode_base(self.config, overrides_of(checked))
        asked = scenario_key_of(checked["key"]) if "key" in checked else None
        super().reset(seed=None if seed is None else whole_number(seed, "seed", 0))
        key = int(self.np_random.integers(2**63))
        key = key if asked is None else asked
        config, self._randomised = draw_config(base, key)
        if config is not self.episode_config:
            self._prepare(config)
        scenario = self.source.draw(key)
        self._world.reset(scenario.place, scenario.people, scenario.recording, key)
        self._key, self._place, self._is_over = key, scenario.name, False
        self._terms, self._record = np.zeros(len(self._term_names)), records(STEP, 1)
        self._gas = scenario.gas
        self._time_free_s = self._free_time_s()
        people = len(scenario.people)
        self._tracks = blank_tracks(people)
        memory = tracker_of(config).latency_steps + 1
        self._history = records(TRACK, memory * people).reshape(memory, people)
        self._perceive()
        self._viewer.begin(config)
        self._show("")
        return self._observe(), self._info()

    def step(
        self, action: object
    ) -> tuple[npt.NDArray[np.float32], SupportsFloat, bool, bool, Info]:
        """Drive for one decision period at the commanded speed."""
        if self._is_over:
            raise InvalidInput("step: the episode is over, call reset first")
        self._command(self._checked(action))
        self._world.advance()  # drive and walk
        check_walk(self.config.people.model, self._world.people)
        self._perceive()
        outcome = self._judge()
        observation = self._observe()
        self._is_over = outcome != RUNNING
        self._show(OUTCOME_NAMES[outcome] if self._is_over else "")
        reward = float(self._terms @ self._weights)
        is_terminated = outcome not in (RUNNING, TIMEOUT)
        return observation, reward, is_terminated, outcome == TIMEOUT, self._info()

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture (H, W, 3) in the mode "rgb_array"; "human" shows it automatically."""
        return self._viewer.picture()

    @property
    def viewer(self) -> Viewer:
        """The painter of the pictures."""
        return self._viewer

    def close(self) -> None:
        """Close the window of the mode "human"; idempotent."""
        self._viewer.close()

    def snapshot(self) -> Snapshot:
        """Return a copy of the true state, for metrics and pictures, not for policies."""
        return self._world.snapshot()._replace(gas=self._gas.copy())

    @property
    def world(self) -> World:
        """The true state, which may be changed between two steps (``sim/intervention.py``)."""
        return self._world

    @property
    def tracks(self) -> Records:
        """The tracker's report of each person: (P,) TRACK records."""
        return self._tracks

    def add_person(self, person: Records) -> int:
        """Add a person, a PERSON record (1,), between two steps; return its index."""
        self._tracks = np.concatenate([self._tracks, blank_tracks(1)])
        unseen = records(TRACK, len(self._history)).reshape(-1, 1)
        self._history = np.concatenate([self._history, unseen], axis=1)
        return self._world.add_person(person)

    # --- inside ----------------------------------------------------------------------------------

    def _checked(self, action: Any) -> float:
        """Return the action in [-1, 1] of a valid action."""
        if self.config.action_type == "discrete":
            if not self.action_space.contains(action):
                raise InvalidInput(f"action: given {action!r}, allowed are the integers 0 to 4")
            return level_action(int(action))
        values = array_of(action, "action")
        if values.shape != (1,) or values.dtype.kind not in "fiu":
            given = f"an array of shape {values.shape} and type {values.dtype}"
            raise InvalidInput(f"action: given {given}, allowed are shape (1,) and numbers")
        value = float(values[0])
        if not abs(value) <= 1.0 + ACTION_TOLERANCE:  # also catches NaN
            raise InvalidInput(f"action: given {value}, allowed is -1 <= action <= 1")
        return value

    def _command(self, action: float) -> None:
        """Command the speed of an action, and record the state before it."""
        world, record = self._world, self._record
        record["s_before_m"], record["command_before_mps"] = (
            world.robots["s"],
            world.robots["command"],
        )
        speed_mps = commanded_speed(action, self.episode_config.drive.nominal_speed_mps)
        world.command(speed_mps, stops=self._reflex())

    def _reflex(self) -> bool:
        """Return True if the reflex is enabled and an obstacle is near ahead."""
        stop_m = self.episode_config.drive.reflex_stop_m
        return stop_m > 0.0 and nearest_ahead(self._ranges, self._ring.view(np.recarray)) < stop_m

    def _perceive(self) -> None:
        """Update ranges and tracks."""
        world = self._world
        perceive_kernel(
            world.robots,
            world.people,
            world.place.walls,
            self._sensors,
            self._ring,
            self._history,
            np.uint64(self._key),
            world.decision,
            self._ranges,
            self._tracks,
        )
        if len(self._gas):
            table = self.source.table.gas
            smell_kernel(
                world.robots, self._gas, table.plume, table.nose, np.uint64(self._key),
                world.decision,
            )  # fmt: skip

    def _judge(self) -> int:
        """Complete the record and the reward terms of the decision; return the outcome."""
        world = self._world
        judge_kernel(
            self._record,
            world.robots,
            world.people,
            world.place.path,
            NO_CONTACT if world.contact is None else world.contact.person,
            world.decision,
            self._rules,
            self._terms,
        )
        if len(self._gas):
            survey_kernel(self._gas, self._record, self.source.table.gas.nose, self._terms)
        if self._own_terms.terms:
            self._own_terms.write(
                world.robots, world.people, self._record, self._rules, self._terms
            )
        return int(self._record["outcome"][0])

    def _observe(self) -> npt.NDArray[np.float32]:
        """Return the observation."""
        world, observation = self._world, np.empty(self._layout.width, dtype=np.float32)
        observe_kernel(
            world.robots, world.place.path, self._ranges, self._tracks, self._gas, observation
        )
        return observation

    def _show(self, outcome: str) -> None:
        if self.render_mode is not None:
            patterns = self._tracks["pattern"].tolist()
            self._viewer.see(
                self._world, self._ranges, patterns, self._terms, outcome, self._gas, self._key
            )

    def _info(self) -> Info:
        """Return the info of a reset or step, always with the same keys."""
        # All fields at once, which is faster.
        *_, outcome, cause, speed_mps, _ = self._record.item()
        info = {
            "scenario_key": self._key,
            "place": self._place,
            "time_free_s": self._time_free_s,
            "time_s": self._world.time_s,
            "reward_terms": dict(zip(self._term_names, self._terms.tolist(), strict=True)),
            "cost": safety_cost(self._terms, cause),
            "outcome": OUTCOME_NAMES[outcome],
            "contact_caused_by": CAUSE_NAMES[cause],
            "contact_speed_mps": speed_mps,
        }
        if len(self._gas):
            info["gas"] = {name: value.item() for name, value in gas_info(self._gas).items()}
        if self._own_terms.terms:
            info["own_terms"] = self._own_terms.info()
        if self._randomised:
            info["randomised"] = self._randomised.copy()
        return info

    def _free_time_s(self) -> float:
        """Return the travel time without people; cached per path."""
        path = self._world.place.path.tobytes()
        if path not in self._free_times:
            self._free_times[path] = self._world.free_time_s()
        return self._free_times[path]


def spaces_of(config: Config) -> tuple[gymnasium.spaces.Box, gymnasium.Space[object]]:
    """Return the observation and action space of one world."""
    layout = layout_in(config)
    observations = gymnasium.spaces.Box(layout.low, layout.high)
    if config.action_type == "discrete":
        return observations, gymnasium.spaces.Discrete(len(SPEED_LEVELS))
    return observations, gymnasium.spaces.Box(-1.0, 1.0, (1,))


def scenario_key_of(given: object) -> int:
    """Return a scenario's key."""
    return whole_number(given, "reset options: key", 0, 2**63 - 1)


CorridorEnv.__doc__ = (
    str(CorridorEnv.__doc__)
    .replace("{observation_table}", markdown_table().replace("\n", "\n    "))
    .replace("{{", "{")
    .replace("}}", "}")
)
