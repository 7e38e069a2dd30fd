"""The native vector environment: N worlds stepped by one compiled kernel.

World i after ``reset(seed=[..., s_i, ...])`` meets the very scenarios and noise that
``CorridorEnv`` meets after ``reset(seed=s_i)``, episode after episode; a parity test holds the two
engines together.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.state import PERSON, Floats, Records, as_record, records
from hazbot_gym.envs.batch import Bools, Episodes, Observations, Outputs, Problem, run_worlds
from hazbot_gym.envs.corridor import SPEED_LEVELS, spaces_of
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.batch import allocate, mechanics
from hazbot_gym.sim.drive import free_time_s
from hazbot_gym.sim.perception import sensor_parameters, tracker_of
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.task.outcome import (
    BY_ROBOT,
    CAUSE_NAMES,
    CONTACT_PERSON,
    CONTACT_WALL,
    DECISION,
    OUTCOME_NAMES,
    RUNNING,
    TIMEOUT,
    Rules,
)
from hazbot_gym.task.place_table import place_at
from hazbot_gym.task.reward import CONTACT, INTRUSION, TERMS
from hazbot_gym.task.scenario import Source

BLOCKS_PER_THREAD, SMALLEST_BLOCK = 4, 32  # blocks of worlds, so that threads end together
KEYS_AHEAD = 16  # scenario keys drawn in advance for each world


class State(NamedTuple):
    """The true state of N worlds, copied; policies must not see it."""

    time_s: Floats  # (N,)
    robots: Records  # (N,) ROBOT
    people: Records  # (N, P) PERSON, those included who are not present


class CorridorVectorEnv(VectorEnv[Observations, Any, Any]):
    """N corridor worlds in one process; see ``CorridorEnv`` for the problem itself.

    Example:
        >>> import gymnasium, hazbot_gym
        >>> envs = gymnasium.make_vec(
        ...     "hazbot_gym/Corridor-v0", num_envs=4, vectorization_mode="vector_entry_point"
        ... )
        >>> observations, infos = envs.reset(seed=0)
        >>> observations.shape
        (4, 48)
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        config: Config | Mapping[str, Any] | str | Path | None = None,
        *,
        preset: Mapping[str, Any] | None = None,
        scenario: str | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        threads: int | None = None,
        **overrides: Any,
    ) -> None:
        """Make N worlds; the arguments not named here are those of ``CorridorEnv``.

        Args:
            num_envs: How many worlds.
            config: As for ``CorridorEnv``, like preset, scenario and overrides.
            preset: Deltas of a registered environment.
            scenario: A named scenario.
            max_episode_steps: Decisions allowed; the config's if None.
            autoreset_mode: What follows the end of an episode.
            render_mode: None; there is no picture of a batch.
            threads: How many to use, one for each core if None; no result depends on it.
            **overrides: Fields of the config.

        Raises:
            InvalidInput: A value cannot be used; one line says which and what is allowed.
        """
        if num_envs < 1:
            raise InvalidInput(f"num_envs: given {num_envs}, allowed is at least 1")
        if render_mode is not None:
            raise InvalidInput(f"render_mode: given {render_mode!r}, allowed here is None")
        if max_episode_steps is not None:
            overrides["max_episode_steps"] = max_episode_steps
        self.config = make_config(config, preset=preset, scenario=scenario, **overrides)
        self.num_envs, self.render_mode = num_envs, render_mode
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space, self.single_action_space = spaces_of(self.config)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._weights = np.array(self.config.reward)
        self._free_times_s: dict[int, float] = {}
        self._thread_count = threads or os.cpu_count() or 1
        self._threads: ThreadPoolExecutor | None = None
        self._generators: list[np.random.Generator] = []
        self._allocate()

    def _allocate(self) -> None:
        config, n = self.config, self.num_envs
        source = Source(config)
        self._place_names = np.array(source.names, object)
        self._problem = Problem(
            table=source.table,
            mechanics=mechanics(config),
            sensors=as_record(sensor_parameters(config)),
            rules=as_record(Rules(config.arrival_tolerance_m, config.max_episode_steps)),
            nobody=records(PERSON, 1),
            start_speed_mps=config.drive.start_speed_mps,
            nominal_speed_mps=config.drive.nominal_speed_mps,
            decision_s=config.clock.decision_s,
        )
        self._worlds = allocate(n, source.people, tracker_of(config).latency_steps)
        self._episodes = Episodes(
            keys=np.zeros((n, KEYS_AHEAD), np.uint64),
            used=np.full(n, KEYS_AHEAD, np.int64),
            places=np.zeros(n, np.int64),
            rows=np.zeros(n, np.int64),
            is_over=np.ones(n, np.bool_),
        )
        width = LAYOUTS[config.tier].width
        self._outputs = Outputs(
            observations=np.zeros((n, width), np.float32),
            final_observations=np.zeros((n, width), np.float32),
            decisions=np.zeros(n, DECISION),
            terms=np.zeros((n, len(TERMS))),
            steps=np.zeros(n, np.int64),
        )

    # --- Gymnasium's interface -------------------------------------------------------------------

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, dict[str, Any]]:
        """Start new episodes: everywhere, or where ``options={"reset_mask": (N,) bool}`` says."""
        mask = self._mask(options)
        self._seed(seed, mask)
        self._refill(mask & (self._episodes.used >= KEYS_AHEAD))
        self._episodes.is_over[mask] = True
        self._run(mask, np.zeros(self.num_envs))
        info = self._info()
        info["scenario_key"] = self._worlds.keys.copy()
        info["_scenario_key"] = mask
        return self._outputs.observations.copy(), info

    def step(
        self, actions: Any, *, mask: Bools | None = None
    ) -> tuple[Observations, Floats, Bools, Bools, dict[str, Any]]:
        """Take one decision in every world; see the autoreset mode for what follows an end.

        Args:
            actions: One for each world.
            mask: (N,) which worlds go on; the others stay, and what they returned last is returned
                again. None for all.
        """
        mask = np.ones(self.num_envs, np.bool_) if mask is None else mask
        over = np.flatnonzero(self._episodes.is_over & mask)
        if self.autoreset_mode == AutoresetMode.DISABLED and len(over):
            raise InvalidInput(
                f"step: the episodes of {len(over)} worlds are over (the first is {over[0]}), "
                "call reset with options={'reset_mask': ...}"
            )
        commands = self._commands(actions)
        self._refill(self._episodes.used >= KEYS_AHEAD)
        self._run(mask, commands)
        outcome = self._outputs.decisions["outcome"]
        truncated = outcome == TIMEOUT
        terminated = (outcome != RUNNING) & ~truncated
        rewards = self._outputs.terms @ self._weights
        return self._outputs.observations.copy(), rewards, terminated, truncated, self._info()

    def state(self) -> State:
        """Return the true state of all worlds, for metrics."""
        time_s = np.round(self._worlds.steps * self.config.clock.decision_s, 9)
        return State(time_s, self._worlds.robots.copy(), self._worlds.people.copy())

    def places(self) -> npt.NDArray[np.object_]:
        """Return what each world's place, or recording, is called (N,)."""
        return self._place_names[self._episodes.places]

    def free_times_s(self) -> Floats:
        """Return how long each world's path takes alone at full speed (N,) [s]."""
        for i in set(self._episodes.places.tolist()) - self._free_times_s.keys():
            self._free_times_s[i] = free_time_s(
                place_at(self._problem.table.places, i).path,
                self._problem.mechanics.drive,
                self._problem.mechanics.gains,
                self._problem.start_speed_mps,
                self.config.arrival_tolerance_m,
            )
        return np.array([self._free_times_s[i] for i in self._episodes.places.tolist()])

    def close_extras(self, **kwargs: Any) -> None:
        """Stop the threads; closing twice does no harm."""
        if self._threads is not None:
            self._threads.shutdown()
            self._threads = None

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: everything but the threads."""
        return {**self.__dict__, "_threads": None}

    # --- inside ----------------------------------------------------------------------------------

    def _run(self, mask: Bools, commands: Floats) -> None:
        """Run the kernel over the worlds of the mask, in blocks on all threads.

        Compiled code holds no lock, and no world knows of another: threads change no result.
        """
        arguments = (
            mask,
            commands,
            self.autoreset_mode == AutoresetMode.SAME_STEP,
            self.config.drive.reflex_stop_m,
            self._worlds,
            self._episodes,
            self._problem,
            self._outputs,
        )
        blocks = _blocks(self.num_envs, self._thread_count)
        if len(blocks) == 1:
            run_worlds(0, self.num_envs, *arguments)
            return
        if self._threads is None:
            self._threads = ThreadPoolExecutor(self._thread_count)
        for job in [self._threads.submit(run_worlds, *block, *arguments) for block in blocks]:
            job.result()

    def _commands(self, actions: Any) -> Floats:
        """Return the commanded speeds (N,) [m/s] of actions, after checking them."""
        nominal, values = self.config.drive.nominal_speed_mps, np.asarray(actions)
        if self.config.action_type == "discrete":
            levels = len(SPEED_LEVELS)
            if values.shape != (self.num_envs,) or not np.all((values >= 0) & (values < levels)):
                raise InvalidInput(
                    f"actions: given shape {values.shape}, allowed are {self.num_envs} "
                    f"integers 0 to {levels - 1}"
                )
            return nominal * np.array(SPEED_LEVELS)[values]
        if values.shape != (self.num_envs, 1):
            raise InvalidInput(
                f"actions: given shape {values.shape}, allowed is ({self.num_envs}, 1)"
            )
        values = values[:, 0].astype(np.float64)
        if not np.all((values >= -1.0) & (values <= 1.0)):  # also catches NaN
            worst = values[~((values >= -1.0) & (values <= 1.0))][0]
            raise InvalidInput(f"actions: given {worst}, allowed is -1 <= action <= 1")
        return nominal * 0.5 * (values + 1.0)

    def _mask(self, options: dict[str, Any] | None) -> Bools:
        unknown = set(options or {}) - {"reset_mask"}
        if unknown:
            raise InvalidInput(
                f"reset options: given {', '.join(sorted(unknown))}, allowed is reset_mask"
            )
        mask = (options or {}).get("reset_mask", np.ones(self.num_envs, np.bool_))
        if not isinstance(mask, np.ndarray) or mask.shape != (self.num_envs,) or mask.dtype != bool:
            raise InvalidInput(
                f"reset_mask: allowed is a boolean array of shape ({self.num_envs},)"
            )
        return mask

    def _seed(self, seed: int | Sequence[int | None] | None, mask: Bools) -> None:
        """Give generators to the worlds that are seeded, and to all that have none."""
        if isinstance(seed, int | np.integer):
            seed = [int(seed) + i for i in range(self.num_envs)]
        seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise InvalidInput(f"seed: given {len(seeds)} seeds for {self.num_envs} worlds")
        is_first = not self._generators
        if is_first:
            self._generators = [np.random.default_rng(0)] * self.num_envs
        for i, value in enumerate(seeds):
            if is_first or (mask[i] and value is not None):
                self._generators[i] = gymnasium.utils.seeding.np_random(value)[0]
                self._episodes.used[i] = KEYS_AHEAD

    def _refill(self, mask: Bools) -> None:
        """Draw the next keys of worlds that have used theirs up."""
        for i in np.flatnonzero(mask):
            # One by one, as CorridorEnv draws them, so that the generators agree.
            generator = self._generators[i]
            self._episodes.keys[i] = [generator.integers(2**63) for _ in range(KEYS_AHEAD)]
            self._episodes.used[i] = 0

    def _info(self) -> dict[str, Any]:
        everyone = np.ones(self.num_envs, np.bool_)
        terms, decisions = self._outputs.terms, self._outputs.decisions
        at_fault = (terms[:, CONTACT] > 0.0) & (decisions["cause"] == BY_ROBOT)
        info: dict[str, Any] = {
            "time_s": np.round(self._outputs.steps * self.config.clock.decision_s, 9),
            "_time_s": everyone,
            "reward_terms": {name: terms[:, k].copy() for k, name in enumerate(TERMS)},
            "_reward_terms": everyone,
            "cost": terms[:, INTRUSION] + at_fault,
            "_cost": everyone,
        }
        ended = decisions["outcome"] != RUNNING
        if ended.any():
            self._add_ends(info, ended)
        return info

    def _add_ends(self, info: dict[str, Any], ended: Bools) -> None:
        """Add how episodes ended, where they did."""
        decisions = self._outputs.decisions
        touched = ended & np.isin(decisions["outcome"], (CONTACT_PERSON, CONTACT_WALL))
        ends = {
            "outcome": np.where(ended, np.array(OUTCOME_NAMES, object)[decisions["outcome"]], None),
            "_outcome": ended,
            "contact_caused_by": np.where(
                touched, np.array(CAUSE_NAMES, object)[decisions["cause"]], None
            ),
            "_contact_caused_by": touched,
            "contact_speed_mps": np.where(touched, decisions["speed_mps"], 0.0),
            "_contact_speed_mps": touched,
        }
        if self.autoreset_mode != AutoresetMode.SAME_STEP:
            info.update(ends)
            return
        final = np.full(self.num_envs, None, object)
        for i in np.flatnonzero(ended):
            final[i] = self._outputs.final_observations[i].copy()
        info.update(
            final_obs=final, _final_obs=ended, final_info={**info, **ends}, _final_info=ended
        )


def _blocks(worlds: int, threads: int) -> list[tuple[int, int]]:
    """Return the ranges of worlds that threads take one after the other."""
    if threads == 1:
        return [(0, worlds)]
    size = max(-(-worlds // (BLOCKS_PER_THREAD * threads)), SMALLEST_BLOCK)
    return [(first, min(first + size, worlds)) for first in range(0, worlds, size)]


def _autoreset_mode(given: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(given) if not isinstance(given, AutoresetMode) else given
    except ValueError as error:
        allowed = ", ".join(mode.value for mode in AutoresetMode)
        raise InvalidInput(f"autoreset_mode: given {given!r}, allowed are {allowed}") from error
