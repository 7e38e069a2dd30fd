"""Reward: weighted sum of named terms, each in a documented range.

reward = sum over terms of weight * term (weights: ``RewardWeights`` in the config). There is no
survival bonus; time enters through the arrival term, the remaining time. With the weights of the
config, a second of the robot's delay costs 1, a second of a person's delay costs the same, and a
second of full discomfort at nominal speed costs 4 (docs/encounters.md: 2.5 to 6.7, as revealed by
drives of a real robot). The only term that penalizes a standing robot is the burden. Blocking one
person for a whole episode costs less than a contact at nominal speed, so that ending an episode by
a crash does not pay.

| term | range | meaning |
|---|---|---|
| progress | [0, 1] | reference point's advance in the decision / the advance at nominal speed |
| intrusion | [0, 1] | nearness to people x the robot's speed / nominal speed, by ``nearness`` |
| tracking | [0, 1] | cross-track and heading error, squared, 1 at 0.3 m or 0.5 rad |
| smoothness | [0, 1] | squared change of the commanded speed / nominal speed |
| burden | [0, people] | relative loss of desired speed by the robot, summed over people |
| contact | [0, 1] | at the end: 0.5 + 0.5 min(speed / 1.5 m/s, 1); a fifth if by a person |
| arrival | [0, horizon in s] | at the end: remaining time to the horizon |
| survey | [-1, 1] | with gas only: leaks reported and missed, false alarms (``task/survey.py``) |

Terms of users come after these (``task/own_terms.py``).

``nearness`` in the config: ``discomfort``, the largest rated discomfort of a person x (v / v_n)^2,
or ``depth``, the deepest intrusion into a personal space x v / v_n.
"""

from __future__ import annotations

import math

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.discomfort import discomfort, facing
from hazbot_gym.core.geometry import clip, norm
from hazbot_gym.core.jit import lean_kernel, scalar
from hazbot_gym.core.proxemics import intrusion_depth
from hazbot_gym.core.state import PRESENT, ROBOT_RADIUS_M, Floats, Records, RobotRecord
from hazbot_gym.task.outcome import (
    ARRIVED,
    BY_PERSON,
    BY_ROBOT,
    CONTACT_PERSON,
    CONTACT_WALL,
    terminate,
)
from hazbot_gym.task.own_terms import OwnTerms
from hazbot_gym.task.step_record import DEPTH, Rules, StepRecord, measure_progress

TERMS = ("progress", "intrusion", "tracking", "smoothness", "burden", "contact", "arrival")
SURVEY_TERM = "survey"  # in environments with gas, after the others
PROGRESS, INTRUSION, TRACKING, SMOOTHNESS, BURDEN, CONTACT, ARRIVAL, SURVEY = range(8)

CROSS_TRACK_M = 0.3  # error at which the tracking term is 1
HEADING_RAD = 0.5
FULL_IMPACT_MPS = 1.5  # contact speed at which the contact term is 1 (brisk walk)
PERSON_CAUSED_SHARE = 0.2  # share of the contact term for a person-caused contact


def terms_of(config: Config) -> tuple[str, ...]:
    """Return the names of an environment's reward terms; those of users come last."""
    return (*_ours(config), *config.own_terms)


def _ours(config: Config) -> tuple[str, ...]:
    return TERMS if config.gas is None else (*TERMS, SURVEY_TERM)


def own_terms_in(config: Config) -> OwnTerms:
    """Return the reward terms of users in an environment."""
    return OwnTerms(config, first=len(_ours(config)))


def weights_of(config: Config) -> Floats:
    """Return the weights of an environment's reward terms."""
    ours = [getattr(config.reward, name) for name in _ours(config)]
    return np.array([*ours, *config.own_terms.values()])


def price_of(config: Config) -> float:
    """Return the price of nearness [s of delay per s of full discomfort]: 4 by default."""
    return -config.reward.intrusion / config.clock.decision_s


@scalar
def nearest_clearance(robot: RobotRecord, people: Records) -> float:
    """Return the clearance to the nearest person, infinite without people [m]."""
    nearest = math.inf
    for i in range(people.shape[0]):
        if people[i].status == PRESENT:
            distance = norm(people[i].x - robot.x, people[i].y - robot.y)
            nearest = min(nearest, distance - people[i].radius - ROBOT_RADIUS_M)
    return nearest


@scalar
def nearness(robot: RobotRecord, people: Records, measure: int) -> float:
    """Return the nearness to people in [0, 1], 0 without people.

    Args:
        robot: The robot's record.
        people: (P,) PERSON records.
        measure: ``DEPTH``, the deepest intrusion into a personal space (``core/proxemics.py``), or
            ``DISCOMFORT``, the largest rated discomfort (``core/discomfort.py``).
    """
    if measure == DEPTH:
        return intrusion_depth(nearest_clearance(robot, people))
    largest = 0.0
    for i in range(people.shape[0]):
        if people[i].status == PRESENT:
            x, y = robot.x - people[i].x, robot.y - people[i].y
            clearance_m = norm(x, y) - people[i].radius - ROBOT_RADIUS_M
            toward = facing(x, y, people[i].vx, people[i].vy)
            largest = max(largest, discomfort(clearance_m, toward))
    return largest


@scalar
def motion(speed_ratio: float, measure: int) -> float:
    """Return the factor of nearness at a speed relative to the nominal speed, in [0, 1].

    Linear with ``DEPTH``; with ``DISCOMFORT`` quadratic, in proportion to the kinetic energy.
    """
    share = clip(abs(speed_ratio), 0.0, 1.0)
    return share if measure == DEPTH else share * share


@scalar
def intrusion(robot: RobotRecord, people: Records, rules: Rules) -> float:
    """Return the nearness to people, scaled by the robot's own motion, in [0, 1].

    Waiting beside a passing person is free; driving beside one is not, since comfort decreases with
    the robot's speed (Neggers et al. 2022).
    """
    near = nearness(robot, people, rules.nearness)
    return near * motion(robot.v / rules.nominal_speed_mps, rules.nearness)


@scalar
def tracking_error(robot: RobotRecord) -> float:
    """Return the normalized squared cross-track and heading error, at most 1."""
    error = (robot.y_e / CROSS_TRACK_M) ** 2 + (robot.theta_e / HEADING_RAD) ** 2
    return min(float(error), 1.0)


@scalar
def burden(people: Records) -> float:
    """Return the relative loss of desired speed, summed over people: delay per second."""
    lost = 0.0
    for i in range(people.shape[0]):
        if people[i].status == PRESENT:
            lost += people[i].blocked
    return lost


@scalar
def contact_severity(cause: int, speed_mps: float) -> float:
    """Return the contact term in [0, 1] for a contact's cause and relative speed."""
    severity = 0.5 + 0.5 * min(speed_mps / FULL_IMPACT_MPS, 1.0)
    return PERSON_CAUSED_SHARE * severity if cause == BY_PERSON else severity


@scalar
def reward_terms(
    robot: RobotRecord, people: Records, record: StepRecord, rules: Rules, out: Floats
) -> None:
    """Write the unweighted terms of one decision.

    Args:
        robot: The robot's record after the decision.
        people: (P,) PERSON records after the decision.
        record: Record of type ``STEP``, with its outcome.
        rules: Scales of a decision, and how nearness is measured.
        out: (7,) terms in the order of ``TERMS``, written.
    """
    out[PROGRESS] = clip(record.progress, 0.0, 1.0)
    out[INTRUSION] = intrusion(robot, people, rules)
    out[TRACKING] = tracking_error(robot)
    out[SMOOTHNESS] = min(record.command_change**2, 1.0)
    out[BURDEN] = burden(people)
    out[CONTACT] = 0.0
    out[ARRIVAL] = 0.0
    if record.outcome == ARRIVED:
        out[ARRIVAL] = record.time_left_s
    elif record.outcome in (CONTACT_PERSON, CONTACT_WALL):
        out[CONTACT] = contact_severity(record.cause, record.contact_speed_mps)


@scalar
def total(terms: Floats, weights: Floats) -> float:
    """Return the reward: the weighted sum of the terms, added up in their order."""
    reward = 0.0
    for k in range(terms.shape[0]):
        reward += weights[k] * terms[k]
    return reward


@scalar
def safety_cost(terms: Floats, cause: int) -> float:
    """Return the cost for constrained learning: intrusion, and 1 for a contact by the robot."""
    is_at_fault = terms[CONTACT] > 0.0 and cause == BY_ROBOT
    return float(terms[INTRUSION]) + (1.0 if is_at_fault else 0.0)


@scalar
def judge(
    record: StepRecord, robot: RobotRecord, people: Records, path: Records, contact: int,
    steps: int, rules: Rules, terms: Floats,
) -> None:  # fmt: skip
    """Complete the record of a decision, and write its unweighted terms.

    Args:
        record: Record of type ``STEP`` with the state before the decision, completed.
        robot: The robot's record.
        people: (P,) PERSON records.
        path: (M,) records of the path.
        contact: Index of the person in contact, ``WALL`` or ``NO_CONTACT``.
        steps: Decisions taken so far, this one included.
        rules: Scales of a decision, and when an episode ends.
        terms: (7,) in the order of ``TERMS``, output.
    """
    measure_progress(record, robot, rules)
    terminate(record, robot, people, path, contact, steps, rules)
    reward_terms(robot, people, record, rules, terms)


@lean_kernel
def judge_kernel(
    records: Records, robots: Records, people: Records, path: Records, contact: int, steps: int,
    rules: Records, terms: Floats,
) -> None:  # fmt: skip
    """Entry point from Python: ``judge`` for arrays of one record."""
    judge(records[0], robots[0], people, path, contact, steps, rules[0], terms)
