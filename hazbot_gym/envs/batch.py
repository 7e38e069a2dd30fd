"""Batched step kernel: physics, sensors, reward and resets of many worlds.

Composes the formulas of ``sim`` and ``task`` for arrays of worlds, as ``envs/corridor.py`` does for
one world on pymunk. Nothing here allocates, and worlds are independent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import LANES, lean_kernel, scalar
from hazbot_gym.core.state import NO_PATTERN, Floats, Records
from hazbot_gym.sim.batch import (
    Group,
    Mechanics,
    Surroundings,
    Worlds,
    place_of,
    start_people,
    step_group,
)
from hazbot_gym.sim.drive import give_command, place_robot
from hazbot_gym.sim.perception import remember, sense_ranges, track_people
from hazbot_gym.sim.walkers import Workspace
from hazbot_gym.task.observation import encode
from hazbot_gym.task.outcome import RUNNING, settle
from hazbot_gym.task.reward import reward_terms, safety_cost, total
from hazbot_gym.task.scenario import ScenarioTable, draw_scenario

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
    decisions: Records  # (N,) DECISION
    terms: Floats  # (N, 7)
    rewards: Floats  # (N,) their weighted sum
    costs: Floats  # (N,) safety cost
    steps: npt.NDArray[np.int64]  # (N,) decisions taken in the episode, its last included


class Problem(NamedTuple):
    """Parameters shared by all worlds, as arrays for kernels."""

    table: ScenarioTable
    mechanics: Mechanics
    sensors: Records  # (1,) SensorParameters
    rules: Records  # (1,) Rules
    weights: Floats  # (7,) of the reward terms
    nobody: Records  # (1,) blank PERSON
    start_speed_mps: float
    nominal_speed_mps: float
    decision_s: float


@scalar
def _surroundings(problem: Problem) -> Surroundings:
    """Return the surroundings of the worlds."""
    return Surroundings(problem.table.places, problem.table.recorded)


# --- one world -----------------------------------------------------------------------------------


@scalar
def _look(i: int, worlds: Worlds, problem: Problem, out: Observations) -> None:
    """Update the sensors of world i, and write its observation."""
    place = place_of(worlds, i, _surroundings(problem))
    p, robot, key, step = problem.sensors[0], worlds.robots[i], worlds.keys[i], worlds.steps[i]
    people, tracks, history = worlds.people[i], worlds.tracks[i], worlds.history[i]
    sense_ranges(robot, people, place.walls, p.ultrasonic, key, step, worlds.ranges[i])
    remember(people, history, step)
    track_people(robot, place.walls, history, p, key, step, tracks)
    encode(robot, place.path, worlds.ranges[i], tracks, out[i])


@scalar
def _reset_world(
    i: int, worlds: Worlds, episodes: Episodes, problem: Problem, outputs: Outputs, work: Workspace
) -> None:
    """Start the next episode of world i; outputs of a step that just ended are kept."""
    if episodes.was_over[i]:
        outputs.terms[i, :] = 0.0
        outputs.rewards[i] = outputs.costs[i] = 0.0
        outputs.decisions[i].outcome = RUNNING
        outputs.steps[i] = 0
    else:
        for k in range(outputs.observations.shape[1]):
            outputs.final_observations[i, k] = outputs.observations[i, k]
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
    path = place_of(worlds, i, _surroundings(problem)).path
    place_robot(
        worlds.robots[i], worlds.wheels[i], path, problem.start_speed_mps, m.drive[0], m.gains
    )
    start_people(worlds, i, _surroundings(problem), m, work)
    _look(i, worlds, problem, outputs.observations)


@scalar
def _decide(
    lane: int, group: Group, command_mps: float, stops: bool, worlds: Worlds, outputs: Outputs
) -> None:
    """Apply the action to the robot in a lane, and record the state before it."""
    i = group.world[lane]
    robot, decision = worlds.robots[i], outputs.decisions[i]
    decision.advance = robot.s
    before_mps = robot.command
    give_command(robot, command_mps, stops, worlds.pending[i], worlds.steps[i])
    decision.command_change = robot.command - before_mps


@scalar
def _judge(
    lane: int, group: Group, worlds: Worlds, episodes: Episodes, problem: Problem,
    outputs: Outputs,
) -> None:  # fmt: skip
    """Compute outcome and reward of the decision in a lane, and update the sensors."""
    i = group.world[lane]
    robot, decision, people = worlds.robots[i], outputs.decisions[i], worlds.people[i]
    path = place_of(worlds, i, _surroundings(problem)).path
    worlds.steps[i] += 1
    nominal = problem.nominal_speed_mps
    decision.advance = (robot.s - decision.advance) / (nominal * problem.decision_s)
    decision.command_change /= nominal
    decision.nominal_speed_mps = nominal
    contact, steps = group.contact[lane], worlds.steps[i]
    settle(decision, robot, people, path, contact, steps, problem.rules[0])
    reward_terms(robot, people, decision, outputs.terms[i])
    outputs.rewards[i] = total(outputs.terms[i], problem.weights)
    outputs.costs[i] = safety_cost(outputs.terms[i], decision.cause)
    _look(i, worlds, problem, outputs.observations)
    outputs.steps[i] = steps
    episodes.is_over[i] = decision.outcome != RUNNING


@scalar
def _reflex(i: int, worlds: Worlds, reflex_stop_m: float) -> bool:
    """Return True if an obstacle ahead triggers the reflex stop."""
    is_near: bool = min(worlds.ranges[i, 0], worlds.ranges[i, 1]) < reflex_stop_m
    return is_near


# --- all worlds ----------------------------------------------------------------------------------


@lean_kernel
def run_worlds(
    first: int,
    last: int,
    mask: Bools,
    commands: Floats,
    is_same_step: bool,
    reflex_stop_m: float,
    worlds: Worlds,
    episodes: Episodes,
    problem: Problem,
    outputs: Outputs,
    group: Records,
    work: Workspace,
) -> None:
    """Step or reset those of the worlds ``first`` to ``last - 1`` that are in the mask.

    A world with an ended episode is reset, the others take a step; with SAME_STEP a world is reset
    as soon as its episode ends. One kernel does both to halve the compile time. ``group`` and
    ``work`` are scratch memory; each thread needs its own.
    """
    lanes, i = group[0], first
    while i < last:
        count = 0
        while i < last and count < LANES:
            episodes.was_over[i] = episodes.is_over[i]
            if mask[i] and not episodes.is_over[i]:
                lanes.world[count] = i
                stops = _reflex(i, worlds, reflex_stop_m)
                _decide(count, lanes, commands[i], stops, worlds, outputs)
                count += 1
            i += 1
        step_group(lanes, count, worlds, _surroundings(problem), problem.mechanics, work)
        for lane in range(count):
            _judge(lane, lanes, worlds, episodes, problem, outputs)
    for i in range(first, last):
        if mask[i] and episodes.is_over[i] and (is_same_step or episodes.was_over[i]):
            _reset_world(i, worlds, episodes, problem, outputs, work)
