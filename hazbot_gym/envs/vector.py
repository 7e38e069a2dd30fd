"""Native Gymnasium vector environment: N worlds stepped by one compiled kernel.

World i after ``reset(seed=[..., s_i, ...])`` has the same scenarios and noise as ``CorridorEnv``
after ``reset(seed=s_i)``, in all episodes; a parity test compares the two engines.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from hazbot_gym.config import Config, make_config
from hazbot_gym.core.jit import LANES
from hazbot_gym.core.own_walking import check_walk
from hazbot_gym.core.state import Floats, Records, records
from hazbot_gym.envs.arguments import Info, episode_base
from hazbot_gym.envs.batch_arrays import KEYS_AHEAD, arrays_of
from hazbot_gym.envs.batch_info import Reported, Scenarios, final_info, rows_of, world_info
from hazbot_gym.envs.batch_input import (
    Seeds,
    actions_of,
    autoreset_mode_of,
    count_of,
    generator_of,
    mask_of,
    reset_options_of,
    seeds_of,
)
from hazbot_gym.envs.batch_step import (
    NEXT_STEP,
    RESET_ENDED,
    SAME_STEP,
    Bools,
    Observations,
    run_worlds,
)
from hazbot_gym.envs.batch_variants import Group, Variant, Variants
from hazbot_gym.envs.batch_viewer import BatchViewer
from hazbot_gym.envs.corridor import spaces_of
from hazbot_gym.envs.spec import CompleteSpec, horizon_given_to_make_vec
from hazbot_gym.errors import InvalidInput
from hazbot_gym.sim.batched_worlds import GROUP, with_room
from hazbot_gym.sim.walkers import Workspace, make_workspace
from hazbot_gym.task.outcome import RUNNING, TIMEOUT
from hazbot_gym.task.randomised import most_people
from hazbot_gym.task.reward import own_terms_in, terms_of
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.utils import processors
from hazbot_gym.utils.threads import Threads

SMALLEST_BLOCK = 32  # minimum worlds per thread


class State(NamedTuple):
    """Copy of the true state of N worlds, not for policies."""

    time_s: Floats  # (N,)
    robots: Records  # (N,) ROBOT
    people: Records  # (N, P) PERSON, including absent people
    gas: Records  # (N,) GAS; (0,) without gas


class ArrayStep(NamedTuple):
    """A step of N worlds without infos of running ones."""

    observations: Observations  # (N, width), of the next episode where one ended
    rewards: Floats  # (N,)
    ended: npt.NDArray[np.bool_]  # (N,)
    truncated: npt.NDArray[np.bool_]  # (N,)
    rows: npt.NDArray[np.int64]  # (E,) worlds whose episode ended
    info: Info  # their infos in Gymnasium's form for SAME_STEP, arrays (E,); {} without any


class CorridorVectorEnv(VectorEnv[Observations, Any, Any]):
    """N corridor worlds in one process; see ``CorridorEnv`` for the problem itself.

    Example:
        >>> import gymnasium, hazbot_gym
        >>> envs = gymnasium.make_vec("hazbot_gym/Corridor-v1", num_envs=4)
        >>> observations, infos = envs.reset(seed=0)
        >>> observations.shape
        (4, 51)
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "render_modes": ["rgb_array"],
        "render_fps": 10,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    spec = CompleteSpec()
    closed = True  # before construction, as some versions of Gymnasium close it then

    def __init__(
        self,
        num_envs: int = 1,
        config: Config | Mapping[str, object] | str | Path | None = None,
        *,
        preset: Mapping[str, object] | None = None,
        scenario: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        threads: int | None = None,
        **overrides: Any,
    ) -> None:
        """Make N worlds; the arguments not named here are those of ``CorridorEnv``.

        Args:
            num_envs: Number of worlds.
            config: As for ``CorridorEnv``, like preset, scenario and overrides.
            preset: Deltas of a registered environment.
            scenario: A named scenario.
            autoreset_mode: Gymnasium's autoreset mode.
            render_mode: "rgb_array" for pictures by ``render``, one of each world.
            threads: Number of threads, one per usable processor if None; results do not depend on
                it.
            **overrides: Fields of the config.

        Raises:
            InvalidInput: A value cannot be used; one line says which and what is allowed.
        """
        self.num_envs = count_of(num_envs, "num_envs")
        self._thread_count = count_of(
            processors.usable() if threads is None else threads, "threads"
        )
        overrides = horizon_given_to_make_vec(self, overrides)
        self.config = make_config(config, preset=preset, scenario=scenario, **overrides)
        self.render_mode = render_mode
        self.autoreset_mode = autoreset_mode_of(autoreset_mode)
        self.metadata = {
            **self.metadata,
            "autoreset_mode": self.autoreset_mode,
            "render_fps": 1.0 / self.config.clock.decision_s,
        }
        self.single_observation_space, self.single_action_space = spaces_of(self.config)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._threads = Threads(max(self._thread_count - 1, 1))
        self._has_run = False
        self.closed = False
        self._generators: list[np.random.Generator] = []
        self._seeds: list[int] = []  # of the generators
        self._allocate()
        self._viewer = None
        if render_mode is not None:
            self._viewer = BatchViewer(render_mode, self.config, self.num_envs, self._variants)

    def _allocate(self) -> None:
        config, n = self.config, self.num_envs
        self._own_terms = own_terms_in(config)
        self._variants = Variants(config, n)
        self._problem = self._variants.first.problem
        people = most_people(config, self._variants.first.source.people)
        self._worlds, self._episodes, self._outputs = arrays_of(config, n, people)
        self._blocks = _blocks(n, self._thread_count)
        self._workspaces = self._make_workspaces(people)
        self._scenarios = Scenarios(
            np.zeros(n, np.int64),
            np.full(n, None, object),
            np.zeros(n),
            self._variants.values.copy(),
        )
        self._finished = self._scenarios  # of the last ended episodes, in SAME_STEP

    # --- Gymnasium's interface -------------------------------------------------------------------

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, Info]:
        """Start new episodes.

        Args:
            seed: As in Gymnasium's vector environments.
            options: ``{"reset_mask": (N,) bool}`` for some worlds only; ``{"key": k}`` for the
                scenario of that key, or a list with one key per world; ``{"config": {...}}`` for
                other values of the config, until the world's next call of ``reset``.
        """
        mask, keys, deltas = reset_options_of(options, self.num_envs)
        base = episode_base(self.config, deltas)
        if seed is None and not self._generators:
            seed = int(cast(int, self.np_random_seed))  # drawn by Gymnasium; repeats what follows
        self._seed(seeds_of(seed, self.num_envs), mask)
        if seed is not None:  # only for the attribute
            is_root = isinstance(seed, int | np.integer) and mask.all()
            told = int(cast(int, seed)) if is_root else tuple(self._seeds)
            self._np_random_seed = cast(int, told)  # Gymnasium knows no seeds of several worlds
        self._refill(mask & (self._episodes.used >= KEYS_AHEAD))
        for i in np.flatnonzero(mask):
            if (key := keys[i]) is not None:  # instead of the drawn key, as in CorridorEnv
                self._episodes.keys[i, self._episodes.used[i]] = key
        self._episodes.is_over[mask] = True
        self._variants.set_base(base, mask)
        self._run(mask, np.zeros(self.num_envs))
        self._scenarios = self._met(mask)
        if self._viewer:
            self._viewer.see(self._worlds, self._outputs, mask, fresh=mask)
        info = self._info(told=mask, fresh=mask)
        return self._outputs.observations.copy(), info

    def step(
        self, actions: Any, *, mask: Bools | None = None
    ) -> tuple[Observations, Floats, Bools, Bools, Info]:
        """Step every world; the autoreset mode determines resets.

        Args:
            actions: One for each world.
            mask: (N,) worlds to step; the others keep their state and last outputs. None for all.
        """
        everyone = np.ones(self.num_envs, np.bool_)
        mask = everyone if mask is None else mask_of(mask, self.num_envs, "mask")
        due = self._episodes.is_over & mask
        ended, truncated = self._advance(actions, mask, due)
        is_same_step = self.autoreset_mode == AutoresetMode.SAME_STEP
        fresh = ended if is_same_step else due
        if self._viewer:
            self._viewer.see(self._worlds, self._outputs, mask, fresh=fresh & mask)
        finished, self._scenarios = self._scenarios, self._met(fresh & mask)
        info = self._info(told=everyone, fresh=fresh)
        if is_same_step and ended.any():
            self._finished = self._finished.replaced(finished, ended & mask)
            info.update(final_info(self._reported(self._finished), self._outputs, ended))
        outputs = self._outputs
        rewards = outputs.rewards.copy()
        return outputs.observations.copy(), rewards, ended & ~truncated, truncated, info

    def step_arrays(self, actions: Any) -> ArrayStep:
        """Step every world without infos of running ones; only with autoreset mode SAME_STEP.

        The arrays are the environment's own, valid until the next step.

        Args:
            actions: One for each world.
        """
        if self.autoreset_mode != AutoresetMode.SAME_STEP:
            raise InvalidInput(
                f"step_arrays: given autoreset_mode {self.autoreset_mode.value!r}, allowed is "
                f"{AutoresetMode.SAME_STEP.value!r}"
            )
        everyone = np.ones(self.num_envs, np.bool_)
        ended, truncated = self._advance(actions, everyone, self._episodes.is_over)
        before, self._scenarios = self._scenarios, self._met(ended)
        rows = np.flatnonzero(ended)
        last: Info = {}
        if len(rows):
            outputs, told = rows_of(self._outputs, rows), np.ones(len(rows), np.bool_)
            gas = self._worlds.gas[rows] if len(self._worlds.gas) else self._worlds.gas
            last = final_info(self._reported(rows_of(before, rows)), outputs, told)
            reported = self._reported(rows_of(self._scenarios, rows))
            last |= world_info(reported, outputs, gas, told=told, fresh=told)
        return ArrayStep(
            self._outputs.observations, self._outputs.rewards, ended, truncated, rows, last
        )

    @property
    def terms(self) -> Floats:
        """Unweighted reward terms of the last decision, (N, terms), valid until the next step."""
        return self._outputs.terms

    @property
    def costs(self) -> Floats:
        """Safety costs of the last decision (N,), valid until the next step."""
        return self._outputs.costs

    @property
    def source(self) -> ScenarioSampler:
        """Sampler of the scenarios of the environment's own config."""
        return self._variants.first.source

    def episode_of(self, i: int) -> tuple[Config, ScenarioSampler]:
        """Return the config of world i's episode, and the sampler of its scenario."""
        variant = self._variants.of(i)
        return variant.config, variant.source

    def state(self) -> State:
        """Return the true state of all worlds, for metrics."""
        worlds = self._worlds
        return State(self._times_s(), worlds.robots.copy(), worlds.people.copy(), worlds.gas.copy())

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a picture (H, W, 3) of each world, all of one size; None without a render mode."""
        return self.pictures(range(self.num_envs))

    def pictures(self, which: range) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Render some worlds only; see ``render``."""
        if self._viewer is None:
            return None
        return self._viewer.pictures(self._worlds, self._times_s(), which)

    def places(self) -> npt.NDArray[np.object_]:
        """Return the name of each world's place or recording (N,)."""
        names: npt.NDArray[np.object_] = self._of_places(lambda each, places: each.names[places])
        return names

    def free_times_s(self) -> Floats:
        """Return the travel time of each world's path without people (N,) [s]."""
        times_s: Floats = self._of_places(lambda each, places: each.free_times_s(places))
        return times_s

    def close_extras(self, **kwargs: object) -> None:
        """Stop the threads; idempotent."""
        self._threads.close()

    # mypy knows no setter of an inherited property.
    @VectorEnv.np_random.setter  # type: ignore[attr-defined, untyped-decorator]
    def np_random(self, value: object) -> None:
        """Not supported: each world has its own generator, seeded by ``reset``."""
        raise InvalidInput(f"np_random: given {value!r}, allowed is reset(seed=...)")

    # --- inside ----------------------------------------------------------------------------------

    def _advance(self, actions: Any, mask: Bools, due: Bools) -> tuple[Bools, Bools]:
        """Step the worlds of a mask; return which episodes ended, and which by the horizon."""
        self._may_step(due)
        checked = actions_of(actions, self.num_envs, self.config)
        self._refill(self._episodes.used >= KEYS_AHEAD)
        self._run(mask, checked)
        check_walk(self.config.people.model, self._worlds.people)
        if self._own_terms.terms:
            self._own_terms.check(self._outputs.terms)
        outcome = self._outputs.records["outcome"]
        return outcome != RUNNING, outcome == TIMEOUT

    def _info(self, *, told: Bools, fresh: Bools) -> Info:
        reported = self._reported(self._scenarios)
        return world_info(reported, self._outputs, self._worlds.gas, told=told, fresh=fresh)

    def _reported(self, scenarios: Scenarios) -> Reported:
        return Reported(
            scenarios, self.config.clock.decision_s, terms_of(self.config), self._own_terms.info()
        )

    def _times_s(self) -> Floats:
        """Return the time since each world's reset (N,) [s]."""
        return np.round(self._worlds.steps * self.config.clock.decision_s, 9)

    def _run(self, mask: Bools, actions: Floats) -> None:
        """Run the kernel over the worlds of the mask, one block per thread.

        Compiled code releases the GIL, and worlds are independent: results do not depend on
        threads. The first call is serial, so that compilation runs in the main thread and can be
        interrupted.
        """
        is_same_step = self.autoreset_mode == AutoresetMode.SAME_STEP
        if self._variants.are_alike:
            first = self._variants.first
            group = Group(first.problem, first.config.drive.reflex_stop_m, mask)
            self._run_groups([group], actions, SAME_STEP if is_same_step else NEXT_STEP)
            return
        over = self._episodes.is_over.copy()
        self._begin_each(mask & over, actions, NEXT_STEP)
        stepped = mask & ~over
        self._run_groups(self._variants.groups(stepped), actions, NEXT_STEP)
        if is_same_step:
            self._begin_each(stepped & self._episodes.is_over, actions, RESET_ENDED)

    def _begin_each(self, mask: Bools, actions: Floats, mode: int) -> None:
        """Begin the next episodes of some worlds, each with a config of its own."""
        groups = []
        for i in np.flatnonzero(mask):
            key = int(self._episodes.keys[i, self._episodes.used[i]])
            variant, only = self._variants.begin(int(i), key), np.zeros_like(mask)
            only[i] = True
            groups.append(Group(variant.problem, variant.config.drive.reflex_stop_m, only))
        if (people := self._variants.people()) > self._worlds.people.shape[1]:
            self._worlds = with_room(self._worlds, people)
            self._workspaces = self._make_workspaces(people)
        self._run_groups(groups, actions, mode)

    def _run_groups(self, groups: Sequence[Group], actions: Floats, mode: int) -> None:
        """Run the kernel over groups of worlds, one block per thread."""
        pieces = [
            [
                (
                    first + int(here[0]), first + int(here[-1]) + 1, group.worlds, actions, mode,
                    group.reflex_stop_m, self._worlds, self._episodes, group.problem,
                    self._outputs, *work,
                )
                for group in groups
                if len(here := np.flatnonzero(group.worlds[first:last]))
            ]
            for (first, last), work in zip(self._blocks, self._workspaces, strict=True)
        ]  # fmt: skip
        if not self._has_run:
            for block in pieces:
                _run_block(block)
            self._has_run = True
            return
        jobs = [self._threads.submit(_run_block, block) for block in pieces[1:]]
        _run_block(pieces[0])
        for job in jobs:
            job.result()

    def _make_workspaces(self, people: int) -> list[tuple[Records, Workspace]]:
        """Return the scratch memory of each thread."""
        room = LANES * people
        return [(records(GROUP, 1), make_workspace(room)) for _ in self._blocks]

    def _of_places(self, value: Callable[[Variant, Any], Any]) -> Any:
        """Return a value of each world's place (N,)."""
        places = self._worlds.places
        if self._variants.are_alike:
            return value(self._variants.first, places)
        return np.concatenate(
            [value(self._variants.of(i), places[i : i + 1]) for i in range(self.num_envs)]
        )

    def _may_step(self, due: Bools) -> None:
        """Raise if a reset is due: before the first reset, and without autoreset."""
        if not self._generators:
            raise InvalidInput("step: no episode has begun, call reset first")
        if self.autoreset_mode == AutoresetMode.DISABLED and due.any():
            raise InvalidInput(
                f"step: the episodes of {due.sum()} worlds are over (the first is {due.argmax()}), "
                "call reset with options={'reset_mask': ...}"
            )

    def _seed(self, seeds: list[int | None], mask: Bools) -> None:
        """Set the generators of seeded worlds, and of worlds without one."""
        if not self._generators:
            made = [generator_of(value) for value in seeds]
            self._generators, self._seeds = map(list, zip(*made, strict=True))
            return
        for i, value in enumerate(seeds):
            if mask[i] and value is not None:
                self._generators[i], self._seeds[i] = generator_of(value)
                self._episodes.used[i] = KEYS_AHEAD

    def _refill(self, mask: Bools) -> None:
        """Draw the next keys of worlds without unused keys."""
        for i in np.flatnonzero(mask):
            # One by one, as in CorridorEnv, so that the generators agree.
            generator = self._generators[i]
            self._episodes.keys[i] = [generator.integers(2**63) for _ in range(KEYS_AHEAD)]
            self._episodes.used[i] = 0

    def _met(self, fresh: Bools) -> Scenarios:
        """Return the current scenarios of the worlds, if some have just been reset."""
        if not fresh.any():
            return self._scenarios
        now = Scenarios(
            self._worlds.keys.astype(np.int64), self.places(), self.free_times_s(),
            self._variants.values,
        )  # fmt: skip
        return self._scenarios.replaced(now, fresh)


def _run_block(pieces: Sequence[tuple[Any, ...]]) -> None:
    """Run the kernel over the groups of a block."""
    for piece in pieces:
        run_worlds(*piece)


def _blocks(worlds: int, threads: int) -> list[tuple[int, int]]:
    """Return the range of worlds of each thread."""
    size = max(-(-worlds // threads), SMALLEST_BLOCK)
    return [(first, min(first + size, worlds)) for first in range(0, worlds, size)]
