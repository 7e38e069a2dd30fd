"""Memory of a scene for a browser: worlds that have begun, and the arguments of the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config, Drive
from hazbot_gym.core.fuzzy_pid import gain_table
from hazbot_gym.core.gas_sensor import gas_sensor_of, nose_of
from hazbot_gym.core.place_table import PlaceTable
from hazbot_gym.core.state import PERSON, as_record, records
from hazbot_gym.envs.batch_arrays import arrays_of
from hazbot_gym.envs.batch_step import NEXT_STEP, Problem, run_worlds
from hazbot_gym.envs.batch_variants import Variant
from hazbot_gym.envs.plume import PlumeGrid
from hazbot_gym.export.plan import Plan, plan_of
from hazbot_gym.export.wasm import Argument, Image, Kernel
from hazbot_gym.live import kernels as own
from hazbot_gym.policies.fuzzy_expert import PERSON_FIELDS, FuzzyExpert
from hazbot_gym.policies.people_rule import with_slots
from hazbot_gym.policies.person_columns import columns_of
from hazbot_gym.policies.undo_lag import UndoLag
from hazbot_gym.sim.batched_worlds import GROUP
from hazbot_gym.sim.walkers import make_workspace
from hazbot_gym.task.observation import Layout, layout_in

GAS_FIELDS = ("gas_reading", "gas_rate_per_s", "gas_alarmed")
CODES = {"float64": "Float64", "int64": "BigInt64", "int32": "Int32", "float32": "Float32"}
COARSE = 2  # every second cell of the gas is drawn


class Start(NamedTuple):
    """Start of an episode: its key, and cells for a picture of its gas."""

    key: int
    grid: PlumeGrid | None


def shared_memory() -> Image:
    """Return the memory that all scenes share: the gains of the wheel loops, and the network."""
    image = Image()
    for array in (gain_table(Drive().tables), *_layers()):
        image.address(array)
    return image


class SceneMemory:
    """One world of a config with all that a browser needs to step it.

    Attributes:
        kernels: The kernels with their arguments, by name.
        calls: Arguments of each kernel for the browser.
    """

    def __init__(self, config: Config, starts: Sequence[Start], shared: Image) -> None:
        self.config, self._starts = config, starts
        self._variant = Variant(config)
        people = max(self._variant.source.people, 1)
        self._arrays = arrays_of(config, 1, people)
        self._room = np.ones(1, np.bool_), np.zeros(1), records(GROUP, 1), make_workspace(people)
        table = self._variant.problem.table
        places = with_own_routes(table.places, people)
        self._problem = self._variant.problem._replace(table=table._replace(places=places))
        self._hand = own.Hand(
            np.zeros(1, np.int64), np.zeros(2), np.zeros(people, np.int64), records(PERSON, people),
            table.places.routes.shape[1], config.clock.decision_s,
        )  # fmt: skip
        self._cells = np.full(max(_coarse(each)[0].size for each in starts), -1, np.int64)
        self._plume = _plume(config, self._cells.size)
        self.kernels = self._kernels()
        self._image = Image(shared)
        state = *self._arrays.worlds, *self._arrays.episodes, *self._arrays.outputs
        for array in (*state, self._hand.is_led, self._cells, self._plume.s_m, self._plume.aside_m):
            self._image.address(array)
        self._state_end = self._image.end
        self.calls: dict[str, list[Argument]] = {
            name: self._image.arguments(*kernel.arguments) for name, kernel in self.kernels.items()
        }

    def _call(self, problem: Problem) -> tuple[Any, ...]:
        mask, actions, group, work = self._room
        worlds, episodes, outputs = self._arrays
        return (
            0, 1, mask, actions, NEXT_STEP, self.config.drive.reflex_stop_m, worlds, episodes,
            problem, outputs, group, work,
        )  # fmt: skip

    def _kernels(self) -> dict[str, Kernel]:
        layout, actions = layout_in(self.config), self._room[1]
        worlds, (seen, *_) = self._arrays.worlds, self._arrays.outputs
        hand = self._hand, worlds.people, worlds.places, self._problem.table.places
        found = {
            "run_worlds": Kernel(run_worlds, self._call(self._problem)),
            "follow_expert": Kernel(own.follow_expert, (seen, _expert(layout), actions)),
            "follow_network": Kernel(own.follow_network, (seen, _learned(layout), actions)),
            "lead": Kernel(own.lead, hand),
            "let_go": Kernel(own.let_go, hand),
        }
        if layout.has_gas:
            inspection = seen, _expert(layout), _inspection(layout), actions
            plume = self._plume, worlds.gas, worlds.keys, worlds.steps
            found["inspect_slowly"] = Kernel(own.inspect_slowly, inspection)
            found["draw_plume"] = Kernel(own.draw_plume, plume)
        return found

    # --- content ----------------------------------------------------------------------------------

    def content(self) -> bytes:
        """Return the memory behind the shared one, and behind it the state at each start."""
        states = []
        for start in self._starts:
            self._begin(start)
            states.append(self._image.content()[: self._state_end - self._image.first])
        return self._image.content() + b"".join(states)

    def _begin(self, start: Start) -> None:
        episodes = self._arrays.episodes
        episodes.keys[0, 0], episodes.used[0], episodes.is_over[0] = start.key, 0, True
        run_worlds(*self._call(self._variant.problem))  # a reset
        at, s_m, aside_m = _coarse(start)
        self._cells[:] = -1
        for array, values in zip(
            (self._cells, self._plume.s_m, self._plume.aside_m), (at, s_m, aside_m), strict=True
        ):
            array[: at.size] = values

    def described(self) -> dict[str, Any]:
        """Return where everything is, as JSON."""
        worlds, episodes, outputs = self._arrays
        arrays = {
            "robot": worlds.robots, "people": worlds.people, "tracks": worlds.tracks,
            "ranges": worlds.ranges, "steps": worlds.steps, "record": outputs.records,
            "reward": outputs.rewards, "observation": outputs.observations,
            "actions": self._room[1], "person": self._hand.person, "point": self._hand.point,
            "is_led": self._hand.is_led, "cells": self._cells, "opacity": self._plume.opacity,
        }  # fmt: skip
        return {
            "first": self._image.first,
            "end": self._image.end,
            "state_end": self._state_end,
            "is_over": self._image.address(episodes.is_over),
            "at": {name: self._described(array) for name, array in arrays.items()},
            "calls": self.calls,
        }

    def _described(self, array: npt.NDArray[Any]) -> dict[str, Any]:
        """Return address, size and count of the records of an array, and its fields."""
        fields = array.dtype.fields or {"": (array.dtype, 0)}
        return {
            "at": self._image.address(array),
            "size": array.dtype.itemsize,
            "count": array.size,
            "fields": {name: [each[1], CODES[each[0].name]] for name, each in fields.items()},
        }


def _plume(config: Config, cells: int) -> own.PlumeCells:
    spread = nose = np.zeros(0, np.void)
    if config.gas is not None:
        spread = as_record(config.gas.plume)
        nose = as_record(nose_of(gas_sensor_of(config.gas.sensor), config.clock.decision_s))
    s_m, aside_m, opacity = np.zeros((3, cells))
    return own.PlumeCells(spread, nose, s_m, aside_m, opacity, config.clock.decision_s)


def with_own_routes(table: PlaceTable, people: int) -> PlaceTable:
    """Return a table with one more route for each person, for those who are led."""

    def longer(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        blank = np.zeros((array.shape[0], people, *array.shape[2:]), array.dtype)
        return np.concatenate([array, blank], axis=1)

    return table._replace(
        routes=longer(table.routes),
        route_counts=np.full_like(table.route_counts, table.routes.shape[1] + people),
        route_kinds=longer(table.route_kinds),
        route_anchors=longer(table.route_anchors),
        route_rooms=longer(table.route_rooms),
    )


def _coarse(start: Start) -> tuple[Any, Any, Any]:
    """Return index in the picture, arc length and lateral position of the cells that are drawn."""
    grid = start.grid
    if grid is None:
        return np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    row, column = np.divmod(grid.cells, grid.shape[1])
    drawn = (row % COARSE == 0) & (column % COARSE == 0)
    columns = -(-grid.shape[1] // COARSE)
    at = row // COARSE * columns + column // COARSE
    return at[drawn], grid.s_m[drawn], grid.aside_m[drawn]


# --- policies ------------------------------------------------------------------------------------


def _expert(layout: Layout) -> own.Expert:
    columns = columns_of(with_slots(layout), PERSON_FIELDS)
    return own.Expert(columns, FuzzyExpert().controller, np.zeros(1), np.zeros(1, np.float32))


def _inspection(layout: Layout) -> own.Inspection:
    rule, at = UndoLag(), [layout.names.index(name) for name in GAS_FIELDS]
    units = np.array([layout.fields[i].scale for i in at])
    return own.Inspection(np.array(at), units, rule.level, rule.slow, rule.lag_s)


def _learned(layout: Layout) -> own.Network:
    """Return the network of the shipped policy."""
    plan = _plan()
    assert plan.rule is None  # a rule that it corrects would need a kernel, too
    entries = np.array([layout.names.index(name) for name in plan.layout.names])
    seen = np.zeros((1, entries.size), np.float32)
    return own.Network(entries, seen, *_layers())


@cache
def _plan() -> Plan:
    return plan_of("ppo")


@cache
def _layers() -> tuple[npt.NDArray[np.float32], ...]:
    """Return weight, bias and room for the outputs of each layer, always the same arrays."""
    actor = _plan().actor
    assert actor is not None
    assert actor.activation == "relu"
    assert actor.head == "clipped"
    assert actor.normalisation is None
    assert actor.lstm is None
    parts = ((each.weight, each.bias, np.zeros((1, each.bias.size))) for each in actor.layers)
    return tuple(np.ascontiguousarray(part, np.float32) for layer in parts for part in layer)
