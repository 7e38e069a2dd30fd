"""One decision of many worlds: physics, senses, reward and resets in a single compiled kernel.

Composes the formulas of ``sim`` and ``task`` for arrays of worlds, as ``envs/corridor.py`` does for
one world on pymunk. Nothing here allocates, and no world knows of another.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.state import NO_PATTERN, Floats, Records
from hazbot_gym.sim.batch import Mechanics, Worlds, step_world
from hazbot_gym.sim.drive import place_robot
from hazbot_gym.sim.people import social_step
from hazbot_gym.sim.perception import remember, sense_ranges, track_people
from hazbot_gym.task.observation import encode
from hazbot_gym.task.outcome import RUNNING, settle
from hazbot_gym.task.place_table import place_at
from hazbot_gym.task.reward import reward_terms
from hazbot_gym.task.scenario import ScenarioTable, draw_scenario, recording_rows

Bools = npt.NDArray[np.bool_]
Observations = npt.NDArray[np.float32]


class Episodes(NamedTuple):
    """Where each world stands in its sequence of episodes."""

    keys: npt.NDArray[np.uint64]  # (N, KEYS_AHEAD) keys of the next episodes
    used: npt.NDArray[np.int64]  # (N,) how many of them are used up
    places: npt.NDArray[np.int64]  # (N,) row of the scenario table's places
    rows: npt.NDArray[np.int64]  # (N,) first row of the recording
    is_over: Bools  # (N,) the episode has ended, a reset is due


class Outputs(NamedTuple):
    """What a step leaves, one row a world."""

    observations: Observations  # (N, width)
    final_observations: Observations  # (N, width) of episodes that ended and were reset at once
    decisions: Records  # (N,) DECISION
    terms: Floats  # (N, 7)
    steps: npt.NDArray[np.int64]  # (N,) decisions taken in the episode, its last included


class Problem(NamedTuple):
    """What is the same in all worlds, as arrays for kernels."""

    table: ScenarioTable
    mechanics: Mechanics
    sensors: Records  # (1,) SensorParameters
    rules: Records  # (1,) Rules
    nobody: Records  # (1,) blank PERSON
    start_speed_mps: float
    nominal_speed_mps: float
    decision_s: float


# --- one world -----------------------------------------------------------------------------------


@scalar
def _look(i: int, worlds: Worlds, episodes: Episodes, problem: Problem, out: Observations) -> None:
    """Let the sensors of world i report, and write its observation."""
    place = place_at(problem.table.places, episodes.places[i])
    p, robot, key, step = problem.sensors[0], worlds.robots[i], worlds.keys[i], worlds.steps[i]
    people, tracks, history = worlds.people[i], worlds.tracks[i], worlds.history[i]
    sense_ranges(robot, people, place.walls, p.ultrasonic, key, step, worlds.ranges[i])
    remember(people, history, step)
    track_people(robot, place.walls, history, p, key, step, tracks)
    encode(robot, place.path, worlds.ranges[i], tracks, out[i])


@scalar
def _reset_world(
    i: int, worlds: Worlds, episodes: Episodes, problem: Problem, outputs: Outputs
) -> None:
    """Start the next episode of world i."""
    m, people, tracks = problem.mechanics, worlds.people[i], worlds.tracks[i]
    key = episodes.keys[i, episodes.used[i]]
    episodes.used[i] += 1
    for k in range(people.shape[0]):
        people[k] = problem.nobody[0]
        tracks[k].visible = 0
        tracks[k].pattern = NO_PATTERN
        for row in range(worlds.history.shape[1]):
            worlds.history[i, row, k].visible = 0
    place_index, first_row = draw_scenario(people, problem.table, key)
    episodes.places[i], episodes.rows[i], episodes.is_over[i] = place_index, first_row, False
    worlds.keys[i], worlds.steps[i] = key, 0
    place = place_at(problem.table.places, place_index)
    row, end = recording_rows(problem.table, place_index, first_row)
    recording = problem.table.recorded.positions[row:end]
    place_robot(
        worlds.robots[i], worlds.wheels[i], place.path, problem.start_speed_mps, m.drive[0], m.gains
    )
    social_step(
        people, place, worlds.robots[i], m.force[0], m.reactions, recording, key, 0, m.social_s
    )
    _look(i, worlds, episodes, problem, outputs.observations)


@scalar
def _step_world(
    i: int, command_mps: float, worlds: Worlds, episodes: Episodes, problem: Problem,
    outputs: Outputs,
) -> None:  # fmt: skip
    """Take one decision in world i."""
    robot, decision = worlds.robots[i], outputs.decisions[i]
    place = place_at(problem.table.places, episodes.places[i])
    row, end = recording_rows(problem.table, episodes.places[i], episodes.rows[i])
    recording = problem.table.recorded.positions[row:end]
    s_before, command_before = robot.s, robot.command
    robot.command = command_mps
    contact = step_world(
        robot, worlds.wheels[i], worlds.people[i], place, problem.mechanics, recording,
        worlds.keys[i], worlds.steps[i],
    )  # fmt: skip
    worlds.steps[i] += 1
    nominal = problem.nominal_speed_mps
    decision.advance = (robot.s - s_before) / (nominal * problem.decision_s)
    decision.command_change = (command_mps - command_before) / nominal
    decision.nominal_speed_mps = nominal
    settle(
        decision, robot, worlds.people[i], place.path, contact, worlds.steps[i], problem.rules[0]
    )
    reward_terms(robot, worlds.people[i], decision, outputs.terms[i])
    _look(i, worlds, episodes, problem, outputs.observations)
    outputs.steps[i] = worlds.steps[i]
    episodes.is_over[i] = decision.outcome != RUNNING


@scalar
def _reflex(i: int, command_mps: float, worlds: Worlds, reflex_stop_m: float) -> float:
    """Return the command, or a stop if something is near in front."""
    nearest = min(worlds.ranges[i, 0], worlds.ranges[i, 1])
    return 0.0 if nearest < reflex_stop_m else command_mps


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
) -> None:
    """Step or reset those of the worlds ``first`` to ``last - 1`` that are in the mask.

    A world whose episode is over is reset, the others take a decision; with SAME_STEP a world is
    reset as soon as its episode ends. One kernel does both: each would take as long to compile.
    """
    for i in range(first, last):
        if not mask[i]:
            continue
        if episodes.is_over[i]:
            _reset_world(i, worlds, episodes, problem, outputs)
            outputs.terms[i, :] = 0.0
            outputs.decisions[i].outcome = RUNNING
            outputs.steps[i] = 0
            continue
        command = _reflex(i, commands[i], worlds, reflex_stop_m)
        _step_world(i, command, worlds, episodes, problem, outputs)
        if is_same_step and episodes.is_over[i]:
            for k in range(outputs.observations.shape[1]):
                outputs.final_observations[i, k] = outputs.observations[i, k]
            _reset_world(i, worlds, episodes, problem, outputs)
