"""Optimal speed plan among people at constant velocity, by dynamic programming.

The lattice has ``LEVELS`` steps of speed from 0 to nominal. In a stage, the robot gains at most one
level. The spacing of places is half the distance covered at one level in a stage, so that a
transition from level i to level j covers i + j places. With the value V_t(i, s) from stage t on,

    V_t(i, s) = max over j of  V_{t+1}(j, s + i + j) - h_{t+1}(j, s + i + j) - w_s (j - i)^2

where h(j, s) is the cost of place s at level j after that stage: the weight of intrusion times the
nearness to people times the factor of motion, as the reward has them, plus the weight of contact
times j/LEVELS if bodies overlap. Standing costs nothing. Progress is the terminal value,
V_T(i, s) = w_p s. The optimum of ``evaluation/oracle/dynamic_programming.py`` is
the same recursion over a whole episode, on a finer lattice, and with known trajectories of people.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.core.discomfort import facing, remoteness
from hazbot_gym.core.elementary import decay
from hazbot_gym.core.geometry import norm
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.proxemics import intrusion_depth
from hazbot_gym.core.state import Floats, Records
from hazbot_gym.policies.people_seen import RADII_M

LEVELS = 5


class Problem(NamedTuple):
    """Parameters of the plan; weights are per stage."""

    stages: int
    stage_s: float
    unit_m: float  # between places
    most_down: int  # levels that a stage may lose
    progress: float  # w_p, for a place
    smoothness: float  # w_s, for a change of one level
    intrusion: float  # for a nearness of 1 at nominal speed
    contact: float  # for contact at nominal speed
    is_rated: bool  # whether nearness is rated discomfort, else depth in personal space


@lean_kernel
def plan(
    people: Floats, way: Floats, speeds: Floats, commands: Floats, problems: Records,
    values: Floats, harm: Floats, out: Floats,
) -> None:  # fmt: skip
    """Write the first speed of each robot's optimal plan.

    Args:
        people: (N, 5, P) the fields of ``people_seen.People``.
        way: (N, 2, S) x and y of the places ahead.
        speeds: (N,) shares of the nominal speed, as below.
        commands: (N,) commanded last.
        problems: (1,) record of ``Problem``.
        values: (2, LEVELS + 1, S) scratch.
        harm: (2, S) scratch, costs of places at nominal speed: of intrusion and of contact.
        out: (N,) output.
    """
    problem = problems[0]
    for n in range(people.shape[0]):
        for level in range(LEVELS + 1):
            for s in range(harm.shape[1]):
                values[0, level, s] = problem.progress * s
        for t in range(problem.stages, 0, -1):
            _look(people[n], way[n], t, problem, harm)
            _charge(values[0], harm, 2 * LEVELS * t + 1, problem, values[1])
            if t > 1:
                _improve(values[1], 2 * LEVELS * (t - 1) + 1, problem, values[0])
        level = int(min(max(speeds[n], 0.0), 1.0) * LEVELS + 0.5)
        out[n] = _first(values[1], level, commands[n] * LEVELS, problem) / LEVELS


@scalar
def _look(people: Floats, way: Floats, t: int, problem: Problem, harm: Floats) -> None:
    """Write the costs of every place reachable in t stages."""
    end, near, touch = 2 * LEVELS * t + 1, harm[0], harm[1]
    for s in range(end):  # until below, remoteness of people and clearance
        near[s] = touch[s] = np.inf
    for i in range(people.shape[1]):
        if people[4, i] > 0.0:
            vx, vy = people[2, i], people[3, i]
            x = people[0, i] + vx * t * problem.stage_s
            y = people[1, i] + vy * t * problem.stage_s
            for s in range(end):  # compiles to vector instructions, as below
                clearance_m = norm(way[0, s] - x, way[1, s] - y) - RADII_M
                touch[s] = clearance_m if clearance_m < touch[s] else touch[s]
            if problem.is_rated:
                for s in range(end):
                    dx, dy = way[0, s] - x, way[1, s] - y
                    remote = remoteness(norm(dx, dy) - RADII_M, facing(dx, dy, vx, vy))
                    near[s] = remote if remote < near[s] else near[s]
    for s in range(end):
        nearness = decay(-near[s]) if problem.is_rated else intrusion_depth(touch[s])
        near[s] = problem.intrusion * nearness
        touch[s] = problem.contact if touch[s] < 0.0 else 0.0


@scalar
def _charge(values: Floats, harm: Floats, end: int, problem: Problem, after: Floats) -> None:
    """Subtract the costs of places at each speed from the values after a stage."""
    for level in range(LEVELS + 1):
        share = level / LEVELS
        motion = share * share if problem.is_rated else share  # as in the reward
        for s in range(end):
            after[level, s] = values[level, s] - harm[0, s] * motion - harm[1, s] * share


@scalar
def _improve(after: Floats, end: int, problem: Problem, best: Floats) -> None:
    """Write the best values before a stage from those after it."""
    for i in range(LEVELS + 1):
        for s in range(end):
            best[i, s] = -np.inf
        for j in range(max(i - problem.most_down, 0), min(i + 1, LEVELS) + 1):
            change = problem.smoothness * (j - i) ** 2
            following = after[j, i + j : i + j + end]
            for s in range(end):  # compiles to vector instructions
                value = following[s] - change
                best[i, s] = value if value > best[i, s] else best[i, s]


@scalar
def _first(after: Floats, level: int, command: float, problem: Problem) -> int:
    """Return the best first level, given the speed and the last command."""
    best, chosen = -np.inf, 0
    for j in range(max(level - problem.most_down, 0), min(level + 1, LEVELS) + 1):
        value = after[j, level + j] - problem.smoothness * (j - command) ** 2
        if value > best:
            best, chosen = value, j
    return chosen
