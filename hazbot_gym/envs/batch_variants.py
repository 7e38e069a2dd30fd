"""Configs of the episodes of a batch, where they differ: overridden by ``reset``, or randomised.

Worlds whose configs differ in nothing that a step depends on are stepped together, in one call of
the kernel; with a continuous distribution in drive, sensors, reactions or the reward, each world is
stepped alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.place_table import place_at
from hazbot_gym.core.state import PERSON, Floats, Place, as_record, records
from hazbot_gym.envs.batch_step import Bools, Problem
from hazbot_gym.sim.batched_worlds import mechanics
from hazbot_gym.sim.drive import free_time_s
from hazbot_gym.sim.perception import ring_of, sensor_parameters
from hazbot_gym.task.randomised import Drawn, draw_config
from hazbot_gym.task.reward import own_terms_in, weights_of
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.task.step_record import rules_of

MOST_KEPT = 256  # variants that are kept for further episodes

# Fields of ``people`` that only the start of an episode depends on.
OF_THE_START = {"count", "mix", "family", "speeds", "reaction_shares", "crossing_window_s"}


class Variant:
    """Parameters of episodes with one config.

    Attributes:
        config: The config.
        source: Sampler of its scenarios.
        problem: Its parameters for the kernels.
        names: Name of each place of its table.
    """

    def __init__(self, config: Config, *, warns: bool = True) -> None:
        self.config, self.source = config, ScenarioSampler(config, warns=warns)
        self.names = np.array(self.source.names, object)
        self.problem = Problem(
            table=self.source.table,
            mechanics=mechanics(config),
            sensors=as_record(sensor_parameters(config)),
            ring=ring_of(config),
            rules=as_record(rules_of(config)),
            weights=weights_of(config),
            own_terms=own_terms_in(config).addresses(),
            nobody=records(PERSON, 1),
            start_speed_mps=config.drive.start_speed_mps,
        )
        self._free_times_s = np.full(len(self.names), np.nan)  # computed on demand
        self._places = dict[int, Place]()

    def free_times_s(self, places: npt.NDArray[np.int64]) -> Floats:
        """Return the travel times of some places' paths without people [s]."""
        for i in np.unique(places[np.isnan(self._free_times_s[places])]):
            self._free_times_s[i] = free_time_s(
                self.place(i).path,
                self.problem.mechanics.drive,
                self.problem.mechanics.gains,
                self.problem.start_speed_mps,
                self.config.arrival_tolerance_m,
            )
        return self._free_times_s[places]

    def place(self, index: int) -> Place:
        """Return a place, always the same object."""
        if index not in self._places:
            self._places[index] = place_at(self.problem.table.places, index)
        return self._places[index]


class Group(NamedTuple):
    """Worlds that are stepped together."""

    problem: Problem
    reflex_stop_m: float
    worlds: Bools  # (N,)


NOTHING: dict[str, object] = {}  # randomised; one for all worlds, since many small ones take room


class Variants:
    """The variant of each world.

    Attributes:
        first: The environment's own variant.
        are_alike: Whether all worlds have it.
        values: Randomised values of each world's episode, by name.
    """

    def __init__(self, config: Config, worlds: int) -> None:
        self.first = Variant(config)
        self._of = [self.first] * worlds
        self._bases = [config] * worlds  # of the next episodes
        self.values: npt.NDArray[np.object_] = np.array([NOTHING] * worlds)
        self._known = {config.model_dump_json(): self.first}
        self._groups = np.zeros(worlds, np.int64)
        self._group_of = {_of_steps(config): 0}
        self._steppers = [self.first]
        self.are_alike = not config.randomised

    def of(self, i: int) -> Variant:
        """Return the variant of world i."""
        return self._of[i]

    def set_base(self, base: Config, worlds: Bools) -> None:
        """Set the config of the next episodes of some worlds."""
        for i in np.flatnonzero(worlds):
            self._bases[i] = base
        is_first = base is self.first.config and not base.randomised
        self.are_alike = is_first and (self.are_alike or bool(worlds.all()))
        if self.are_alike:
            self._of = [self.first] * len(self._of)
            self._groups[:] = 0
            self.values[:] = NOTHING

    def begin(self, i: int, key: int) -> Variant:
        """Return the variant of world i's next episode."""
        drawn = draw_config(self._bases[i], key)
        self._of[i], self.values[i] = self._variant(drawn), drawn.values
        self._groups[i] = self._group(self._of[i])
        return self._of[i]

    def people(self) -> int:
        """Return the largest number of PERSON records of a world."""
        return max(variant.source.people for variant in set(self._of))

    def groups(self, worlds: Bools) -> list[Group]:
        """Return some worlds in groups that are stepped together."""
        return [
            Group(
                self._steppers[k].problem,
                self._steppers[k].config.drive.reflex_stop_m,
                worlds & (self._groups == k),
            )
            for k in np.unique(self._groups[worlds])
        ]

    def _variant(self, drawn: Drawn) -> Variant:
        name = drawn.config.model_dump_json()
        if name not in self._known:
            if len(self._known) >= MOST_KEPT:
                self._known = {}
            self._known[name] = Variant(drawn.config, warns=False)
        return self._known[name]

    def _group(self, variant: Variant) -> int:
        """Return the number of a variant's group; those of no world are given up now and then."""
        name = _of_steps(variant.config)
        if name not in self._group_of:
            if len(self._steppers) >= MOST_KEPT + 2 * len(self._of):
                self._regroup()
            self._group_of[name] = len(self._steppers)
            self._steppers.append(variant)
        return self._group_of[name]

    def _regroup(self) -> None:
        used = np.unique(self._groups)
        self._steppers = [self._steppers[k] for k in used]
        self._groups = np.searchsorted(used, self._groups)
        self._group_of = {_of_steps(each.config): k for k, each in enumerate(self._steppers)}


def _of_steps(config: Config) -> str:
    """Return the values that steps depend on."""
    return config.model_dump_json(exclude={"people": OF_THE_START, "randomised": True})


def columns_of(values: npt.NDArray[np.object_], told: Bools) -> dict[str, Any]:
    """Return an array and a mask of worlds for each randomised value."""
    found: dict[str, Any] = {}
    for name in dict.fromkeys(name for each in values[told] for name in each):
        has = told & np.array([name in each for each in values])
        known = [each[name] for each in values[has]]
        is_numeric = all(type(value) in (int, float) for value in known)
        column = np.zeros(len(values)) if is_numeric else np.full(len(values), None, object)
        for i, value in zip(np.flatnonzero(has), known, strict=True):
            column[i] = value
        found |= {name: column, f"_{name}": has}
    return found
