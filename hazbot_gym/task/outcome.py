"""Outcome of a decision: end of the episode, and cause of a contact."""

from __future__ import annotations

import math

from hazbot_gym.core.geometry import norm, path_length
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import WALL, PersonRecord, Records, RobotRecord
from hazbot_gym.task.step_record import Rules, StepRecord

RUNNING, ARRIVED, CONTACT_PERSON, CONTACT_WALL, TIMEOUT = range(5)
OUTCOME_NAMES = ("running", "arrived", "contact_person", "contact_wall", "timeout")
NOBODY, BY_ROBOT, BY_PERSON = range(3)
CAUSE_NAMES = ("nobody", "robot", "person")

TIE_MPS = 0.01  # closing speeds that differ by less count as equal, for robustness to noise
MOVING_MPS = 0.05  # a slower robot counts as standing


@scalar
def contact_cause(robot: RobotRecord, person: PersonRecord) -> tuple[int, float]:
    """Return the cause of a contact, and its relative speed [m/s] (as in SEAN 2.0 and HuNavSim).

    The robot is the cause if it moves, and closes in at least as fast as the person.
    """
    dx, dy = person.x - robot.x, person.y - robot.y
    distance = max(norm(dx, dy), 1e-9)
    robot_vx, robot_vy = robot.v * math.cos(robot.theta), robot.v * math.sin(robot.theta)
    robot_closing = (robot_vx * dx + robot_vy * dy) / distance
    person_closing = -(person.vx * dx + person.vy * dy) / distance
    by_robot = abs(robot.v) > MOVING_MPS and robot_closing > person_closing - TIE_MPS
    speed = norm(robot_vx - person.vx, robot_vy - person.vy)
    return BY_ROBOT if by_robot else BY_PERSON, speed


@scalar
def terminate(
    record: StepRecord, robot: RobotRecord, people: Records, path: Records, contact: int,
    steps: int, rules: Rules,
) -> None:  # fmt: skip
    """Write the outcome of a decision.

    Args:
        record: Record of type ``STEP``, output.
        robot: The robot's record.
        people: (P,) PERSON records.
        path: (M,) records of the path.
        contact: Index of the person in contact, ``WALL`` or ``NO_CONTACT``.
        steps: Decisions taken so far.
        rules: When an episode ends.
    """
    outcome, cause, speed_mps = RUNNING, NOBODY, 0.0
    if contact >= 0:
        outcome = CONTACT_PERSON
        cause, speed_mps = contact_cause(robot, people[contact])
    elif contact == WALL:
        outcome, cause, speed_mps = CONTACT_WALL, BY_ROBOT, abs(robot.v)
    elif path_length(path) - robot.s - robot.x_e <= rules.arrival_tolerance_m:
        outcome = ARRIVED
    elif steps >= rules.horizon:
        outcome = TIMEOUT
    record.outcome = outcome
    record.cause = cause
    record.contact_speed_mps = speed_mps
    record.time_left_s = (rules.horizon - steps) * rules.decision_s
