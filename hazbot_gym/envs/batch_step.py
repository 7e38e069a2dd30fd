"""Batched step kernel: physics, sensors, reward and resets of many worlds.

The order of a step is that of ``envs/corridor.py``, one world on pymunk (``task/step_record.py``).
Nothing here allocates, and worlds are independent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.geometry import path_length
from hazbot_gym.core.hooks import call
from hazbot_gym.core.jit import LANES, lean_kernel, scalar
from hazbot_gym.core.state import NO_PATTERN, Floats, Ints, Records
from hazbot_gym.sim.batched_worlds import (
    Mechanics,
    Surroundings,
    Worlds,
    advance_group,
    place_of,
    start_people,
)
from hazbot_gym.sim.drive import command_robot, place_robot
from hazbot_gym.sim.perception import nearest_ahead, perceive
from hazbot_gym.sim.smell import smell
from hazbot_gym.sim.walkers import Workspace
from hazbot_gym.task.action import commanded_speed
from hazbot_gym.task.leak import clear_gas, draw_leak
from hazbot_gym.task.observation import observe
from hazbot_gym.task.outcome import RUNNING
from hazbot_gym.task.reward import SURVEY, judge, safety_cost, total
from hazbot_gym.task.scenario import ScenarioTable, draw_scenario
from hazbot_gym.task.step_record import open_record
from hazbot_gym.task.survey import survey

NEXT_STEP, SAME_STEP, RESET_ENDED = range(3)  # modes of ``run_worlds``

Bools = npt.NDArray[np.bool_]
Observations = npt.NDArray[np.float32]


class Episodes(NamedTuple):
    """Episode bookkeeping of each world."""

    keys: npt.NDArray[np.uint64]  # (N, KEYS_AHEAD) keys of the next episodes
    used: npt.NDArray[np.int64]  # (N,) number of used keys
    is_over: Bools  # (N,) the episode has ended, a reset is due
    was_over: Bools  # (N,) the same flag before the last step


class Outputs(NamedTuple):
    """Outputs of a step, one row per world."""

    observations: Observations  # (N, width)
    final_observations: Observations  # (N, width) of episodes that ended and were reset at once
    records: Records  # (N,) STEP
    terms: Floats  # (N, 7), with gas (N, 8); those of users come last
    rewards: Floats  # (N,) their weighted sum
    costs: Floats  # (N,) safety cost
    steps: npt.NDArray[np.int64]  # (N,) decisions taken in the episode, its last included
    final_gas: Records  # (N,) GAS of episodes that ended and were reset at once; (0,) without gas


class Problem(NamedTuple):
    """Parameters shared by all worlds, as arrays for kernels."""

    table: ScenarioTable
    mechanics: Mechanics
    sensors: Records  # (1,) SensorParameters
    ring: Records  # (n,) RING, range sensors
    rules: Records  # (1,) Rules
    weights: Floats  # of the reward terms
    own_terms: Ints  # addresses of the reward terms of users
    nobody: Records  # (1,) blank PERSON
    start_speed_mps: float


@scalar
def surroundings_of(problem: Problem) -> Surroundings:
    """Return the surroundings of the worlds."""
    return Surroundings(problem.table.places, problem.table.recorded)


# --- one world -----------------------------------------------------------------------------------


@scalar
def command_world(
    i: int, action: float, reflex_stop_m: float, worlds: Worlds, problem: Problem, outputs: Outputs
) -> None:
    """Command the speed of an action to the robot of world i, and record the state before it."""
    robot = worlds.robots[i]
    open_record(outputs.records[i], robot)
    speed_mps = commanded_speed(action, problem.rules[0].nominal_speed_mps)
    stops = nearest_ahead(worlds.ranges[i], problem.ring) < reflex_stop_m
    command_robot(robot, speed_mps, stops, worlds.pending[i], worlds.steps[i])


@scalar
def perceive_world(i: int, worlds: Worlds, problem: Problem) -> None:
    """Update the sensors of world i."""
    perceive(
        worlds.robots[i], worlds.people[i], place_of(worlds, i, surroundings_of(problem)).walls,
        problem.sensors[0], problem.ring, worlds.history[i], worlds.keys[i], worlds.steps[i],
        worlds.ranges[i], worlds.tracks[i],
    )  # fmt: skip
    if worlds.gas.shape[0] > 0:
        gas = problem.table.gas
        smell(
            worlds.robots[i], worlds.gas[i], gas.plume[0], gas.nose[0], worlds.keys[i],
            worlds.steps[i],
        )  # fmt: skip


@scalar
def judge_world(i: int, contact: int, worlds: Worlds, problem: Problem, outputs: Outputs) -> bool:
    """Write outcome, reward and cost of world i; return True if its episode is over."""
    record, terms, steps = outputs.records[i], outputs.terms[i], worlds.steps[i]
    path = place_of(worlds, i, surroundings_of(problem)).path
    judge(record, worlds.robots[i], worlds.people[i], path, contact, steps, problem.rules[0], terms)
    if worlds.gas.shape[0] > 0:
        terms[SURVEY] = survey(worlds.gas[i], record.outcome, problem.table.gas.nose[0])
    first = terms.shape[0] - problem.own_terms.shape[0]
    for k in range(problem.own_terms.shape[0]):
        call(
            problem.own_terms[k], worlds.robots[i], worlds.people[i], record, problem.rules[0],
            terms[first + k : first + k + 1],
        )  # fmt: skip
    outputs.rewards[i] = total(terms, problem.weights)
    outputs.costs[i] = safety_cost(terms, record.cause)
    outputs.steps[i] = steps
    is_over: bool = record.outcome != RUNNING
    return is_over


@scalar
def observe_world(i: int, worlds: Worlds, problem: Problem, outputs: Outputs) -> None:
    """Write the observation of world i."""
    path = place_of(worlds, i, surroundings_of(problem)).path
    observe(
        worlds.robots[i], path, worlds.ranges[i], worlds.tracks[i], worlds.gas[i : i + 1],
        outputs.observations[i],
    )  # fmt: skip


@scalar
def _reset_world(
    i: int, worlds: Worlds, episodes: Episodes, problem: Problem, outputs: Outputs, work: Workspace
) -> None:
    """Start the next episode of world i; outputs of a step that just ended are kept."""
    if episodes.was_over[i]:
        outputs.terms[i, :] = 0.0
        outputs.rewards[i] = outputs.costs[i] = 0.0
        outputs.records[i].outcome = RUNNING
        outputs.steps[i] = 0
    else:
        for k in range(outputs.observations.shape[1]):
            outputs.final_observations[i, k] = outputs.observations[i, k]
        if worlds.gas.shape[0] > 0:
            outputs.final_gas[i] = worlds.gas[i]
    m, people, tracks = problem.mechanics, worlds.people[i], worlds.tracks[i]
    key = episodes.keys[i, episodes.used[i]]
    episodes.used[i] += 1
    for k in range(people.shape[0]):
        people[k] = problem.nobody[0]
        tracks[k].visible = 0
        tracks[k].pattern = NO_PATTERN
        for row in range(worlds.history.shape[1]):
            worlds.history[i, row, k].visible = 0
    worlds.places[i], worlds.starts[i] = draw_scenario(people, problem.table, key)
    worlds.keys[i], worlds.steps[i] = key, 0
    episodes.is_over[i] = False
    for k in range(worlds.pending.shape[1]):
        worlds.pending[i, k] = problem.start_speed_mps
    path = place_of(worlds, i, surroundings_of(problem)).path
    if worlds.gas.shape[0] > 0:
        table = problem.table.gas
        left_m, right_m = table.sides[worlds.places[i], 0], table.sides[worlds.places[i], 1]
        clear_gas(worlds.gas[i])
        draw_leak(worlds.gas[i], table.rules[0], path_length(path), left_m, right_m, key)
    place_robot(
        worlds.robots[i], worlds.wheels[i], path, problem.start_speed_mps, m.drive[0], m.gains
    )
    start_people(worlds, i, surroundings_of(problem), m, work)
    perceive_world(i, worlds, problem)
    observe_world(i, worlds, problem, outputs)


# --- all worlds ----------------------------------------------------------------------------------


@lean_kernel
def run_worlds(
    first: int,
    last: int,
    mask: Bools,
    actions: Floats,
    mode: int,
    reflex_stop_m: float,
    worlds: Worlds,
    episodes: Episodes,
    problem: Problem,
    outputs: Outputs,
    group: Records,
    work: Workspace,
) -> None:
    """Step or reset those of the worlds ``first`` to ``last - 1`` that are in the mask.

    A world with an ended episode is reset, the others take a step; with the mode SAME_STEP a world
    is reset as soon as its episode ends, with RESET_ENDED worlds are reset whose episodes have just
    ended, as if by SAME_STEP. One kernel does all to halve the compile time. ``group`` and
    ``work`` are scratch memory; each thread needs its own.
    """
    lanes, i = group[0], first
    while i < last:
        count = 0
        while i < last and count < LANES:
            if mask[i] and mode != RESET_ENDED:
                episodes.was_over[i] = episodes.is_over[i]
            if mask[i] and not episodes.is_over[i]:
                lanes.world[count] = i
                command_world(i, actions[i], reflex_stop_m, worlds, problem, outputs)
                count += 1
            i += 1
        advance_group(lanes, count, worlds, surroundings_of(problem), problem.mechanics, work)
        for lane in range(count):
            stepped = lanes.world[lane]
            worlds.steps[stepped] += 1
            perceive_world(stepped, worlds, problem)
            episodes.is_over[stepped] = judge_world(
                stepped, lanes.contact[lane], worlds, problem, outputs
            )
            observe_world(stepped, worlds, problem, outputs)
    for i in range(first, last):
        if mask[i] and episodes.is_over[i] and (mode != NEXT_STEP or episodes.was_over[i]):
            _reset_world(i, worlds, episodes, problem, outputs, work)
