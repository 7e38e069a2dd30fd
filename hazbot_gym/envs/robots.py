"""Several robots in one place, as a parallel environment of PettingZoo."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.own_walking import check_walk
from hazbot_gym.core.place_table import stack_places
from hazbot_gym.core.recorded_table import NO_RECORDING
from hazbot_gym.core.state import (
    NO_CONTACT,
    NO_PATTERN,
    PRESENT,
    ROBOT_RADIUS_M,
    SCRIPTED,
    WAITING,
    Floats,
    Records,
    records,
)
from hazbot_gym.envs.arguments import Info
from hazbot_gym.envs.batch_input import actions_of
from hazbot_gym.envs.batch_step import Outputs, Problem
from hazbot_gym.envs.batch_variants import Variant
from hazbot_gym.envs.corridor import scenario_key_of, spaces_of
from hazbot_gym.envs.robots_step import Robots, start_robots, step_robots
from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.sim.batched_worlds import GROUP, Worlds, allocate
from hazbot_gym.sim.drive import free_time_s
from hazbot_gym.sim.perception import tracker_of
from hazbot_gym.sim.walkers import make_workspace
from hazbot_gym.task.crowd import ROBOT_ROOM_M
from hazbot_gym.task.observation import layout_in
from hazbot_gym.task.outcome import CAUSE_NAMES, OUTCOME_NAMES, RUNNING, TIMEOUT
from hazbot_gym.task.reward import own_terms_in, terms_of
from hazbot_gym.task.robot_paths import START_SPREAD_M, lanes_in, robot_paths
from hazbot_gym.task.scenario import CROWD, Scenario
from hazbot_gym.task.step_record import STEP
from hazbot_gym.utils.whole_number import whole_number

try:
    from pettingzoo import ParallelEnv
except ImportError as error:
    raise MissingExtra(error.name or "pettingzoo", "robots") from error

MOST_ROBOTS = 6
NOISE_SHIFT = 60  # bits of the scenario's key from here on tell the noise of the robots apart

Observation = npt.NDArray[np.float32]


class CorridorParallelEnv(ParallelEnv[str, Observation, Any]):  # type: ignore[misc]  # untyped
    """Robots that meet on opposite and crossing paths, each choosing its own speed.

    Observation, action and reward of a robot are those of ``CorridorEnv``. Its tracker and range
    sensors report the other robots like people; its reward knows them only by contacts. A robot
    whose episode has ended is no longer in the place.

    ``info`` of a robot has the keys of ``CorridorEnv``; a contact with another robot has the
    outcome ``contact_robot``, caused by ``robot`` or ``other_robot``.

    Attributes:
        agents: Names of the robots whose episodes are running.
        possible_agents: Names of all robots.
        config: The config.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "name": "hazbot_robots_v1",
        "render_modes": [],
        "is_parallelizable": True,
    }
    render_mode = None

    def __init__(
        self,
        robots: int = 2,
        config: Config | Mapping[str, object] | str | Path | None = None,
        *,
        preset: Mapping[str, object] | None = None,
        keep_right_m: float | None = None,
        start_spread_m: float = START_SPREAD_M,
        **overrides: Any,
    ) -> None:
        """Make a place with several robots.

        Args:
            robots: Number of robots, at most 6.
            config: As for ``CorridorEnv``, like preset and overrides.
            preset: Deltas of a registered environment.
            keep_right_m: Lateral distance of a robot's path from the middle of its way; default
                0.6 m, or 0.45 m where walls are nearer.
            start_spread_m: Starts are drawn up to this far behind the beginning of the way.
            **overrides: Fields of the config.

        Raises:
            InvalidInput: A value cannot be used, or the place is too narrow; one line.
        """
        count = whole_number(robots, "robots", 1, MOST_ROBOTS)
        self.config = make_config(config, preset=preset, **overrides)
        variant = Variant(self.config)
        self._source, self._problem = variant.source, variant.problem
        self._check()
        self._lanes = lanes_in(
            self.config.place, self._source.draw(0).place, count,
            right_m=keep_right_m, spread_m=start_spread_m,
        )  # fmt: skip
        self.possible_agents = [f"robot_{i}" for i in range(count)]
        self.agents: list[str] = []
        spaces = [spaces_of(self.config) for _ in range(count)]
        self.observation_spaces = dict(
            zip(self.possible_agents, [s[0] for s in spaces], strict=True)
        )
        self.action_spaces = dict(zip(self.possible_agents, [s[1] for s in spaces], strict=True))
        self._own_terms = own_terms_in(self.config)
        self._group = records(GROUP, 1)
        self._work = make_workspace(count * (self._source.people + count))
        self._random = np.random.default_rng()

    def reset(
        self, seed: int | None = None, options: Mapping[str, object] | None = None
    ) -> tuple[dict[str, Observation], dict[str, Info]]:
        """Start an episode of all robots.

        Args:
            seed: As in Gymnasium.
            options: ``{"key": k}`` for the scenario of that key; unknown ones are ignored, as
                PettingZoo asks for.

        Raises:
            InvalidInput: Other values of the config are asked for, or an argument cannot be used.
        """
        if seed is not None:
            self._random = np.random.default_rng(whole_number(seed, "seed", 0))
        self._key = int(self._random.integers(2**63))
        if not isinstance(options, Mapping | None):
            raise InvalidInput(f"reset options: given {options!r}, allowed is a dict with key")
        if options and "config" in options:
            raise InvalidInput("reset options: given config, allowed with several robots is key")
        if options and "key" in options:
            self._key = scenario_key_of(options["key"])
        scenario = self._source.draw(self._key)
        count = len(self.possible_agents)
        paths = robot_paths(scenario.place, count, self._lanes, self._key)
        self._episode = _with_paths(self._problem, scenario, paths)
        self._worlds = self._filled(scenario, paths)
        self._robots = Robots(
            len(scenario.people), np.ones(count, np.bool_), np.full(count, NO_CONTACT)
        )
        self._outputs = self._blank_outputs()
        self._decision, self._place, self._shown = 0, scenario.name, 0
        m = self._problem.mechanics
        start_mps, tolerance_m = self._problem.start_speed_mps, self.config.arrival_tolerance_m
        self._free_times_s = [
            free_time_s(path, m.drive, m.gains, start_mps, tolerance_m) for path in paths
        ]
        start_robots(self._worlds, self._robots, self._episode, self._outputs, self._work)
        self.agents = self.possible_agents[:]
        return self._observations(self.agents), self._infos(self.agents)

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]
    ]:
        """Drive all robots for one decision period.

        Args:
            actions: One for each of ``agents``.

        Returns:
            Observations, rewards, terminations, truncations and infos of these robots.
        """
        acting = self.agents
        step_robots(
            self._checked(actions), self._decision, self.config.clock.social_per_decision,
            self.config.drive.reflex_stop_m, self._worlds, self._robots, self._episode,
            self._outputs, self._group, self._work,
        )  # fmt: skip
        self._decision += 1
        check_walk(self.config.people.model, self._worlds.people)
        self._own_terms.check(self._outputs.terms)
        self._shown = self._moving(acting)
        outcomes = self._outputs.records["outcome"]
        ended = dict(zip(self.possible_agents, (outcomes != RUNNING).tolist(), strict=True))
        timed = dict(zip(self.possible_agents, (outcomes == TIMEOUT).tolist(), strict=True))
        rewards = dict(zip(self.possible_agents, self._outputs.rewards.tolist(), strict=True))
        self.agents = [name for name in acting if not ended[name]]
        return (
            self._observations(acting),
            {name: rewards[name] for name in acting},
            {name: ended[name] and not timed[name] for name in acting},
            {name: timed[name] for name in acting},
            self._infos(acting),
        )

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return a robot's observation space, always the same object."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return a robot's action space, always the same object."""
        return self.action_spaces[agent]

    @property
    def robots(self) -> Records:
        """A copy of the true state of all robots, (R,) ROBOT records, in the order of the names."""
        return self._begun().robots.copy()

    @property
    def people(self) -> Records:
        """A copy of the true state of the people: (P,) PERSON records."""
        return self._begun().people[self._shown, : self._robots.people].copy()

    # --- inside ----------------------------------------------------------------------------------

    def _begun(self) -> Worlds:
        """Return the worlds, once there has been a reset."""
        if not hasattr(self, "_worlds"):
            raise InvalidInput("robots: no episode has begun, call reset first")
        return self._worlds

    def _check(self) -> None:
        """Raise for a config that is only for one robot."""
        only_one = {
            "gas": self.config.gas is not None,
            "randomised values": bool(self.config.randomised),
            "recordings or listed walkers": self._source.table.kind != CROWD,
        }
        for name, is_given in only_one.items():
            if is_given:
                raise InvalidInput(f"robots: given {name}, allowed is a config without")

    def _filled(self, scenario: Scenario, paths: list[Records]) -> Worlds:
        """Return a world for each robot with all people, and blank records of the robots."""
        count, people = len(paths), len(scenario.people)
        worlds = allocate(
            count, people + count, len(self._problem.ring),
            tracker_latency=tracker_of(self.config).latency_steps,
            drive_latency=self.config.drive.latency_steps, has_gas=False,
        )  # fmt: skip
        worlds.people[:, :people] = _clear_of(scenario.people, paths)
        bodies = worlds.people[:, people:]  # walk nowhere by a script
        bodies["model"], bodies["radius"] = SCRIPTED, ROBOT_RADIUS_M
        worlds.tracks["pattern"] = NO_PATTERN
        worlds.pending[:] = self._problem.start_speed_mps
        for i in range(count):
            worlds.keys[i] = self._key ^ (i << NOISE_SHIFT)
            worlds.places[i] = i
        return worlds

    def _blank_outputs(self) -> Outputs:
        count, width = len(self.possible_agents), layout_in(self.config).width
        return Outputs(
            observations=np.zeros((count, width), np.float32),
            final_observations=np.zeros((0, width), np.float32),
            records=np.zeros(count, STEP),
            terms=np.zeros((count, len(terms_of(self.config)))),
            rewards=np.zeros(count),
            costs=np.zeros(count),
            steps=np.zeros(count, np.int64),
            final_gas=np.zeros_like(self._worlds.gas),
        )

    def _checked(self, actions: Mapping[str, Any]) -> Floats:
        """Return actions (R,) in [-1, 1], 0 for robots that are gone."""
        if not self.agents:
            raise InvalidInput("step: no episode is running, call reset first")
        if not isinstance(actions, Mapping):
            kind = type(actions).__name__
            raise InvalidInput(f"actions: given {kind}, allowed is a mapping from names to actions")
        if set(actions) != set(self.agents):
            given, allowed = ", ".join(map(str, actions)) or "none", ", ".join(self.agents)
            raise InvalidInput(f"actions: given those of {given}, allowed is one each of {allowed}")
        values = np.zeros(len(self.possible_agents))
        here = [self.possible_agents.index(name) for name in self.agents]
        chosen = [actions[name] for name in self.agents]
        values[here] = actions_of(chosen, len(here), self.config)
        return values

    def _moving(self, acting: list[str]) -> int:
        """Return a robot that drove in the last decision, if possible up to its end."""
        indices = [self.possible_agents.index(name) for name in acting]
        return next((i for i in indices if self._robots.contacts[i] == NO_CONTACT), indices[0])

    def _observations(self, names: list[str]) -> dict[str, Observation]:
        rows = dict(zip(self.possible_agents, self._outputs.observations, strict=True))
        return {name: rows[name].copy() for name in names}

    def _infos(self, names: list[str]) -> dict[str, Info]:
        return {name: self._info(self.possible_agents.index(name)) for name in names}

    def _info(self, i: int) -> Info:
        """Return the info of robot i, with the keys of ``CorridorEnv``."""
        *_, outcome, cause, speed_mps, _ = self._outputs.records[i].item()
        terms = zip(terms_of(self.config), self._outputs.terms[i].tolist(), strict=True)
        is_with_robot = self._robots.contacts[i] >= self._robots.people
        causes = {"person": "other_robot"} if is_with_robot else {}
        info = {
            "scenario_key": self._key,
            "place": self._place,
            "time_free_s": self._free_times_s[i],
            "time_s": round(self._decision * self.config.clock.decision_s, 9),
            "reward_terms": dict(terms),
            "cost": float(self._outputs.costs[i]),
            "outcome": "contact_robot" if is_with_robot else OUTCOME_NAMES[outcome],
            "contact_caused_by": causes.get(CAUSE_NAMES[cause], CAUSE_NAMES[cause]),
            "contact_speed_mps": speed_mps,
        }
        return info | ({"own_terms": self._own_terms.info()} if self._own_terms.terms else {})


parallel_env = CorridorParallelEnv  # the name by which PettingZoo makes environments


def _with_paths(problem: Problem, scenario: Scenario, paths: list[Records]) -> Problem:
    """Return the parameters of an episode: a place for each robot, with its path."""
    places = stack_places([scenario.place._replace(path=path) for path in paths])
    nothing = NO_RECORDING._replace(recording_of_place=np.zeros(len(paths), np.int64))
    return problem._replace(
        table=problem.table._replace(places=places, recorded=nothing),
        mechanics=problem.mechanics._replace(social_per_decision=1),
    )


def _clear_of(people: Records, paths: list[Records]) -> Records:
    """Return people of whom those beside a robot at its start wait until there is room."""
    starts = np.array([path[0][["x", "y"]].item() for path in paths])
    away_m = np.hypot(people["x"][:, None] - starts[:, 0], people["y"][:, None] - starts[:, 1]).min(
        axis=1
    )
    waiting = people.copy()
    waiting["status"][(people["status"] == PRESENT) & (away_m < ROBOT_ROOM_M)] = WAITING
    return waiting
