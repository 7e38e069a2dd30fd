"""Dynamic programming: the exact optimal return of a scenario with non-reactive people.

The state is time, place on the path and speed. With V(t, s, v) the best return from decision t,

    V(t, s, v) = max over v' of  r(t, s, v, v') + V(t + 1, s + a(v, v'), v')

where v' is a speed of the lattice that the slew limits allow within a decision, a(v, v') the
distance covered, and r the reward of the environment. It is exact, not interpolated: under the
limits of the config the reachable places lie on a lattice too (for the default, multiples of 0.25
mm). It is an upper bound for every policy with commands on the same speeds, if

- people do not react to the robot (scripted walkers), so that their paths are known in advance;
- the drive is ideal (``wheel_loop: ideal``, no noise), so that the pose follows from s.

Commands beyond the slew limits gain nothing: the speed is the same as with commands within the
limits, and the smoothness term penalizes every change of the command.

The optimum knows the future, so part of its margin over policies is unattainable.
"""

from __future__ import annotations

import math
from typing import NamedTuple, cast

import numpy as np
import numpy.typing as npt

from hazbot_gym.config import Config
from hazbot_gym.core.geometry import nearest_on_segment, norm, path_length, sample_path
from hazbot_gym.core.jit import lean_kernel, routine, scalar
from hazbot_gym.core.proxemics import PERSONAL_M
from hazbot_gym.core.state import (
    NO_CONTACT,
    PRESENT,
    ROBOT,
    ROBOT_RADIUS_M,
    SCRIPTED,
    Floats,
    Records,
    RobotRecord,
    records,
)
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.oracle.lattice import LEVELS, Lattice, lattice_of
from hazbot_gym.sim.contact import find_contact
from hazbot_gym.sim.people import move_people
from hazbot_gym.sim.unattended import walk_unattended
from hazbot_gym.task.outcome import BY_ROBOT, contact_cause
from hazbot_gym.task.reward import (
    ARRIVAL,
    CONTACT,
    INTRUSION,
    PROGRESS,
    SMOOTHNESS,
    contact_severity,
    intrusion,
    motion,
    nearest_clearance,
    nearness,
    weights_of,
)
from hazbot_gym.task.scenario import Scenario
from hazbot_gym.task.step_record import DEPTH, Rules, rules_of

UNIT_TOLERANCE = 1e-6  # of a unit, tolerance between distances and the lattice
BLOCK = 512  # places processed together
HURRY, SWERVE_M = 1.2, 0.02  # deviation of people from constant velocity within a decision


class Optimum(NamedTuple):
    """Optimal return and, if requested, the speeds that achieve it [m/s]."""

    value: float
    speeds_mps: Floats


def optimum(config: Config, scenario: Scenario, key: int, *, with_speeds: bool = False) -> Optimum:
    """Return the optimal return of a scenario and, if requested, the speeds that achieve it.

    Args:
        config: of the environment; see the conditions above.
        scenario: drawn from that config.
        key: of the scenario.
        with_speeds: store the best action of every state, in a few hundred MB.

    Raises:
        InvalidInput: people react to the robot, or the drive is not ideal.
    """
    _refuse(config, scenario)
    lattice, clock = lattice_of(config), config.clock
    decisions = config.max_episode_steps
    people = walk_unattended(
        scenario.people.copy(), scenario.place, config.people.force, key=key,
        steps=decisions * clock.social_per_decision + 1, dt_s=clock.social_s,
    )  # fmt: skip
    goal_m = path_length(scenario.place.path.view(np.recarray)) - config.arrival_tolerance_m
    goal = math.ceil(goal_m / lattice.unit_m - UNIT_TOLERANCE)
    room = goal + int(lattice.ways.max()) + 1
    ways_m = cast(Floats, np.arange(room) * lattice.unit_m)
    poses = sample_path(scenario.place.path, ways_m)[:, :3].copy()
    values = np.zeros((2, LEVELS, room))
    depths, near = np.zeros((2, room)), np.zeros(room, np.bool_)
    choices = np.zeros((decisions if with_speeds else 1, LEVELS, room), np.int8)
    robots, touched = records(ROBOT, 1), people[0].copy()
    problem = _Problem(
        goal=goal,
        reach=int(lattice.ways.max()),
        decisions=decisions,
        rules=rules_of(config),
        physics_s=clock.physics_s,
        physics_per_social=clock.physics_per_social,
        social_per_decision=clock.social_per_decision,
    )
    weights = weights_of(config)
    _solve(
        problem, lattice, weights, people, scenario.place.walls, poses, robots, touched, values,
        depths, near, choices,
    )  # fmt: skip
    start = int(np.argmin(np.abs(lattice.speeds_mps - config.drive.start_speed_mps)))
    speeds = _follow(choices, lattice, start, goal) if with_speeds else np.zeros(0)
    return Optimum(float(values[0, start, 0]), speeds)


class _Problem(NamedTuple):
    goal: int  # units to the goal
    reach: int  # units of the longest way in a decision
    decisions: int  # allowed
    rules: Rules
    physics_s: float
    physics_per_social: int
    social_per_decision: int


def is_exact_for(config: Config) -> bool:
    """Return True if the optimum is exact: no reactions, no gas, and an ideal drive."""
    return config.people.model == "scripted" and config.gas is None and _is_as_told(config)


def _is_as_told(config: Config) -> bool:
    drive = config.drive
    is_ideal = drive.wheel_loop == "ideal" and not drive.heading_noise_rad
    return is_ideal and not (
        drive.reflex_stop_m or drive.latency_steps or drive.line_sensor.pitch_m
    )


def _refuse(config: Config, scenario: Scenario) -> None:
    if np.any(scenario.people["model"] != SCRIPTED):
        raise InvalidInput(
            f"people.model: given {config.people.model!r}, whose people react to the robot; "
            "the optimum is exact for 'scripted' alone"
        )
    if not _is_as_told(config):
        raise InvalidInput(
            "drive: the optimum needs wheel_loop ideal, heading_noise_rad, reflex_stop_m and "
            "latency_steps 0, and no line_sensor"
        )


def _follow(choices: npt.NDArray[np.int8], lattice: Lattice, level: int, goal: int) -> Floats:
    """Return the speed after each decision from the start to the goal."""
    s, speeds = 0, []
    for choice in choices:
        if s >= goal:
            break
        following = int(choice[level, s])
        s += int(lattice.ways[level, following])
        level = following
        speeds.append(lattice.speeds_mps[level])
    return np.array(speeds)


@lean_kernel
def _solve(
    problem: _Problem, lattice: Lattice, weights: Floats, people: Records, walls: Floats,
    poses: Floats, robots: Records, touched: Records, values: Floats, depths: Floats,
    near: npt.NDArray[np.bool_], choices: npt.NDArray[np.int8],
) -> None:  # fmt: skip
    """Run the backward recursion; the values of decision 0 end in ``values[0]``.

    Args:
        problem: Constants of the recursion.
        lattice: Speeds and ways.
        weights: (7,) of the reward terms.
        people: (steps, P) records at every social step.
        walls: (W, 4) segments.
        poses: (S, 3) x, y and heading at every place of the lattice.
        robots: (1,) ROBOT record, scratch.
        touched: (P,) PERSON records, scratch.
        values: (2, V, S) of a decision and of the next one, alternating.
        depths: (2, S) nearness to people at each place, likewise.
        near: (S,) whether a contact is possible from there, scratch.
        choices: (T, V, S) best next speed of every state, output; (1, V, S) to keep the last only.
    """
    last, every = problem.decisions, problem.social_per_decision
    keeps = choices.shape[0] == last
    _look(people[last * every], poses, robots[0], problem, depths[last % 2], near)
    for t in range(last - 1, -1, -1):
        now, then = t % 2, (t + 1) % 2
        _look(people[t * every], poses, robots[0], problem, depths[now], near)
        arrival = weights[ARRIVAL] * (last - (t + 1)) * problem.rules.decision_s
        for level in range(lattice.speeds_mps.shape[0]):
            for s in range(problem.goal, poses.shape[0]):
                values[then, level, s] = arrival
        end = min(problem.goal, t * problem.reach + 1)  # upper bound of the distance covered
        row = t if keeps else 0
        for first in range(0, end, BLOCK):
            last_one = min(first + BLOCK, end)
            for level in range(lattice.speeds_mps.shape[0]):
                _improve(
                    level, first, last_one, problem, lattice, weights, depths[then], values[then],
                    values[now, level], choices[row, level],
                )  # fmt: skip
        for level in range(lattice.speeds_mps.shape[0]):
            for s in range(end):
                if near[s]:
                    value, following = _weigh(
                        t, s, level, problem, lattice, weights, people, walls, poses, robots[0],
                        touched, depths[then], values[then],
                    )  # fmt: skip
                    values[now, level, s] = value
                    choices[row, level, s] = following


@scalar
def _look(
    people: Records,
    poses: Floats,
    robot: RobotRecord,
    problem: _Problem,
    depths: Floats,
    near: npt.NDArray[np.bool_],
) -> None:
    """Write the nearness to people at every place, and whether a contact is possible there."""
    measure = problem.rules.nearness
    reach_m = PERSONAL_M if measure == DEPTH else np.inf  # of the term
    for first in range(0, poses.shape[0], BLOCK):
        last = min(first + BLOCK, poses.shape[0]) - 1
        robot.x, robot.y = poses[first, 0], poses[first, 1]
        block_m = norm(poses[last, 0] - poses[first, 0], poses[last, 1] - poses[first, 1])
        is_far = nearest_clearance(robot, people) > reach_m + 2.0 * block_m
        for s in range(first, last + 1):
            depths[s], near[s] = 0.0, False
            if not is_far:
                robot.x, robot.y = poses[s, 0], poses[s, 1]
                depths[s] = nearness(robot, people, measure)
                near[s] = _may_touch(robot, people, problem)


@scalar
def _may_touch(robot: RobotRecord, people: Records, problem: _Problem) -> bool:
    """Return True if a person who is clear of the robot now may touch it within a decision."""
    own_way_m = problem.rules.nominal_speed_mps * problem.rules.decision_s
    for i in range(people.shape[0]):
        me = people[i]
        if me.status != PRESENT:
            continue
        reach_m, ahead_s = me.radius + ROBOT_RADIUS_M, HURRY * problem.rules.decision_s
        x, y = nearest_on_segment(
            robot.x, robot.y, me.x, me.y, me.x + ahead_s * me.vx, me.y + ahead_s * me.vy
        )
        is_clear = norm(me.x - robot.x, me.y - robot.y) >= reach_m
        if is_clear and norm(x - robot.x, y - robot.y) <= reach_m + own_way_m + SWERVE_M:
            return True
    return False


@scalar
def reward_of(
    level: int, following: int, lattice: Lattice, weights: Floats, rules: Rules
) -> tuple[float, float]:
    """Return the reward of a decision without people, and its slope over the nearness to people.

    The sum of these terms of ``task/reward.py``, written out so that places compile to vector
    instructions.
    """
    nominal_mps = rules.nominal_speed_mps
    advance = lattice.ways[level, following] * lattice.unit_m / (nominal_mps * rules.decision_s)
    change = (lattice.speeds_mps[following] - lattice.speeds_mps[level]) / nominal_mps
    sure = weights[PROGRESS] * advance + weights[SMOOTHNESS] * change * change
    return sure, weights[INTRUSION] * motion(
        lattice.speeds_mps[following] / nominal_mps, rules.nearness
    )


@scalar
def _improve(
    level: int, first: int, end: int, problem: _Problem, lattice: Lattice, weights: Floats,
    depths: Floats, values: Floats, best: Floats, chosen: npt.NDArray[np.int8],
) -> None:  # fmt: skip
    """Write the best value of a speed at some places and the next speed, assuming no contact.

    Args:
        level: The speed.
        first: First place.
        end: The place after the last.
        problem: Constants of the recursion.
        lattice: Speeds and ways.
        weights: (7,) of the reward terms.
        depths: (S,) nearness to people after the decision.
        values: (V, S) after the decision.
        best: (S,) value, written.
        chosen: (S,) next speed, written.
    """
    count, block, choice = end - first, best[first:end], chosen[first:end]
    for k in range(count):
        block[k] = -np.inf
    for following in range(lattice.speeds_mps.shape[0]):
        way = lattice.ways[level, following]
        if way < 0:
            continue
        sure, slope = reward_of(level, following, lattice, weights, problem.rules)
        depth, after = depths[first + way : end + way], values[following, first + way : end + way]
        for k in range(count):  # compiles to vector instructions
            value = sure + slope * depth[k] + after[k]
            is_better = value > block[k]
            block[k] = value if is_better else block[k]
            choice[k] = following if is_better else choice[k]


@routine
def _weigh(
    t: int, s: int, level: int, problem: _Problem, lattice: Lattice, weights: Floats,
    people: Records, walls: Floats, poses: Floats, robot: RobotRecord, touched: Records,
    depths: Floats, values: Floats,
) -> tuple[float, int]:  # fmt: skip
    """Return the best value of a speed at one place, contacts included, and the next speed."""
    best, chosen = -np.inf, 0
    for following in range(lattice.speeds_mps.shape[0]):
        way = lattice.ways[level, following]
        if way < 0:
            continue
        sure, slope = reward_of(level, following, lattice, weights, problem.rules)
        value = _touch(
            t, s, level, following, problem, lattice, weights, people, walls, poses, robot, touched
        )
        if math.isnan(value):
            value = sure + slope * depths[s + way] + values[following, s + way]
        if value > best:
            best, chosen = value, following
    return best, chosen


@routine
def _touch(
    t: int, s: int, level: int, following: int, problem: _Problem, lattice: Lattice,
    weights: Floats, people: Records, walls: Floats, poses: Floats, robot: RobotRecord,
    touched: Records,
) -> float:  # fmt: skip
    """Return the reward of a decision that ends in a contact; NaN without a contact."""
    way_m = 0.0
    for k in range(lattice.substeps_mps.shape[2]):
        v = lattice.substeps_mps[level, following, k]
        way_m += v * problem.physics_s
        place = s + int(way_m / lattice.unit_m + 0.5)
        robot.x, robot.y, robot.theta = poses[place, 0], poses[place, 1], poses[place, 2]
        robot.v = v
        step = t * problem.social_per_decision + k // problem.physics_per_social
        elapsed_s = (k % problem.physics_per_social + 1) * problem.physics_s
        contact = find_contact(people[step], walls, robot, elapsed_s)
        if contact != NO_CONTACT:
            for i in range(touched.shape[0]):
                touched[i] = people[step, i]
            move_people(touched, elapsed_s)
            cause, speed_mps = BY_ROBOT, abs(v)
            if contact >= 0:
                cause, speed_mps = contact_cause(robot, touched[contact])
            way = lattice.ways[level, following]
            sure, _ = reward_of(level, following, lattice, weights, problem.rules)
            not_made_m = way * lattice.unit_m - way_m
            ended: float = (
                sure
                - weights[PROGRESS]
                * not_made_m
                / (problem.rules.nominal_speed_mps * problem.rules.decision_s)
                + weights[INTRUSION] * intrusion(robot, touched, problem.rules)
                + weights[CONTACT] * contact_severity(cause, speed_mps)
            )
            return ended
    return np.nan
