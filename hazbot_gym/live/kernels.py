"""Kernels of the page without a server: policies, and the hand that leads people.

A browser runs them beside the engine's own (``export/wasm.py``). On valid observations they answer
as the policies in Python; observations are (1, n), and actions (1,) what the engine is given.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.fuzzy import SpeedRules
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.place_table import PlaceTable, place_at
from hazbot_gym.core.state import PRESENT, Floats, Ints, Records
from hazbot_gym.envs.plume import opacity_of, steady_readings
from hazbot_gym.policies.fuzzy_expert import answer
from hazbot_gym.policies.guard import Observations
from hazbot_gym.policies.layer import Floats32, map_rows
from hazbot_gym.policies.person_columns import Columns
from hazbot_gym.sim.intervention import go_on, walk_to


class Expert(NamedTuple):
    """The fuzzy expert with its defaults (``FuzzyExpert``)."""

    columns: Columns
    controller: SpeedRules
    horizons_s: Floats  # (1,)
    kept: Floats32  # (1,) its speed factor


class Inspection(NamedTuple):
    """Slow speed where the gas sensor heads for a level (``UndoLag``)."""

    entries: Ints  # (3,) of reading, rate and alarm
    units: Floats  # (3,)
    level: float
    slow: float
    lag_s: float


class Network(NamedTuple):
    """A network of three layers (``Actor``), with room for what they answer (1, ...)."""

    entries: Ints  # that it reads
    seen: Floats32
    weight_1: Floats32
    bias_1: Floats32
    out_1: Floats32
    weight_2: Floats32
    bias_2: Floats32
    out_2: Floats32
    weight_3: Floats32
    bias_3: Floats32
    out_3: Floats32


class Hand(NamedTuple):
    """A person who is led, and where to."""

    person: Ints  # (1,)
    point: Floats  # (2,) [m]
    is_led: Ints  # (P,)
    before: Records  # (P,) PERSON, as they were
    first_row: int  # of the routes; each person has one of its own from here on
    dt_s: float


class PlumeCells(NamedTuple):
    """Cells of a picture of the gas, and what their opacity depends on."""

    spread: Records  # (1,) Plume of ``core/gas.py``
    nose: Records  # (1,) Nose
    s_m: Floats  # (N,) arc length of the path
    aside_m: Floats  # (N,) lateral position
    opacity: Floats  # (N,)
    decision_s: float


# --- policies ------------------------------------------------------------------------------------


@scalar
def _action(share: float) -> np.float32:
    """Return the action for a share of the nominal speed, in the precision of ``speed_action``."""
    return np.float32(2.0) * np.float32(share) - np.float32(1.0)


@lean_kernel
def follow_expert(observation: Observations, expert: Expert, actions: Floats) -> None:
    """Write the fuzzy expert's action."""
    columns, controller = expert.columns, expert.controller
    answer(observation, columns, controller, False, 1.0, expert.horizons_s, expert.kept)
    actions[0] = _action(expert.kept[0])


@lean_kernel
def inspect_slowly(
    observation: Observations, expert: Expert, inspection: Inspection, actions: Floats
) -> None:
    """Write the slower of two actions: the fuzzy expert's, and that of an inspection."""
    columns, controller = expert.columns, expert.controller
    answer(observation, columns, controller, False, 1.0, expert.horizons_s, expert.kept)
    at, units, seen = inspection.entries, inspection.units, observation[0]
    heads_for = seen[at[0]] * units[0] + inspection.lag_s * (seen[at[1]] * units[1])
    is_slow = heads_for > inspection.level and seen[at[2]] * units[2] < 0.5
    share = inspection.slow if is_slow else 1.0
    actions[0] = _action(min(share, np.float64(expert.kept[0])))


@lean_kernel
def follow_network(observation: Observations, network: Network, actions: Floats) -> None:
    """Write the action of a network (``TrainedActor``)."""
    for k in range(network.entries.shape[0]):
        network.seen[0, k] = observation[0, network.entries[k]]
    map_rows(network.seen, network.weight_1, network.bias_1, network.out_1)
    _rectify(network.out_1)
    map_rows(network.out_1, network.weight_2, network.bias_2, network.out_2)
    _rectify(network.out_2)
    map_rows(network.out_2, network.weight_3, network.bias_3, network.out_3)
    actions[0] = _clipped(network.out_3[0, 0])


@scalar
def _clipped(action: np.float32) -> np.float32:
    return min(max(action, np.float32(-1.0)), np.float32(1.0))


@scalar
def _rectify(rows: Floats32) -> None:
    for k in range(rows.shape[1]):
        rows[0, k] = max(rows[0, k], np.float32(0.0))


# --- gas -----------------------------------------------------------------------------------------


@lean_kernel
def draw_plume(plume: PlumeCells, gas: Records, keys: npt.NDArray[np.uint64], steps: Ints) -> None:
    """Write the opacity of the gas in each cell of a picture, as ``PlumeGrid.opacity`` does."""
    time_s = steps[0] * plume.decision_s
    steady_readings(
        gas, plume.spread, plume.nose, plume.s_m, plume.aside_m, time_s, keys[0], plume.opacity
    )
    for k in range(plume.opacity.shape[0]):
        plume.opacity[k] = opacity_of(plume.opacity[k])


# --- people --------------------------------------------------------------------------------------


@lean_kernel
def lead(hand: Hand, people: Records, places: Ints, table: PlaceTable) -> None:
    """Let a present person of a single world walk to the hand's point (``Intervention.lead``)."""
    i, place = hand.person[0], place_at(table, places[0])
    if people[0, i].status != PRESENT:
        return
    if not hand.is_led[i]:
        hand.before[i] = people[0, i]
        hand.is_led[i] = 1
    walk_to(
        people[0, i], place.routes, hand.first_row + i, place.walls, hand.point[0], hand.point[1],
        hand.dt_s,
    )  # fmt: skip


@lean_kernel
def let_go(hand: Hand, people: Records, places: Ints, table: PlaceTable) -> None:
    """Let a person who is led go on by its own model (``Intervention.release``)."""
    i = hand.person[0]
    if hand.is_led[i] and people[0, i].status == PRESENT:
        routes = place_at(table, places[0]).routes
        go_on(people[0, i], hand.before[i], routes, hand.first_row + i)
    hand.is_led[i] = 0
