"""Step record: the data of a decision and its outcome, written by both engines.

Both engines take a step in the same order:

1. command: map the action to a commanded speed, and queue it (``task/action.py``, ``sim/drive.py``)
2. drive: move the robot at 100 Hz (``sim/drive.py``)
3. walk: move the people, and update their velocities at 20 Hz (``sim/people.py``)
4. perceive: update range readings and tracks (``sim/perception.py``)
5. judge: outcome, reward terms, reward and cost (``task/reward.py``)
6. observe: encode the observation (``task/observation.py``)

The record holds the robot's state before the decision from ``command`` on, and the rest from
``judge`` on.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.jit import scalar
from hazbot_gym.core.state import RobotRecord

STEP = np.dtype(
    [
        ("s_before_m", "f8"),  # reference point's arc length before the decision
        ("command_before_mps", "f8"),  # commanded speed before it
        ("progress", "f8"),  # advance of the reference point / its advance at nominal speed
        ("command_change", "f8"),  # change of the commanded speed / nominal speed
        ("outcome", "i8"),  # RUNNING, ARRIVED, ...
        ("cause", "i8"),  # of a contact: BY_ROBOT or BY_PERSON
        ("contact_speed_mps", "f8"),  # relative speed of a contact
        ("time_left_s", "f8"),  # remaining time to the horizon [s]
    ],
    align=True,
)


class StepRecord(Protocol):
    """One element of an array of ``STEP``."""

    s_before_m: float
    command_before_mps: float
    progress: float
    command_change: float
    outcome: int
    cause: int
    contact_speed_mps: float
    time_left_s: float


DEPTH, DISCOMFORT = range(2)  # measures of nearness, in the order of ``NEARNESS``
NEARNESS = ("depth", "discomfort")


class Rules(NamedTuple):
    """Scales of a decision, when an episode ends, and how nearness is measured."""

    nominal_speed_mps: float
    decision_s: float
    arrival_tolerance_m: float  # tolerance of arrival at the path's end
    horizon: int  # in decisions
    nearness: int = DEPTH  # or DISCOMFORT


def rules_of(config: Config) -> Rules:
    """Return the rules of a config."""
    return Rules(
        nominal_speed_mps=config.drive.nominal_speed_mps,
        decision_s=config.clock.decision_s,
        arrival_tolerance_m=config.arrival_tolerance_m,
        horizon=config.max_episode_steps,
        nearness=NEARNESS.index(config.nearness),
    )


@scalar
def open_record(record: StepRecord, robot: RobotRecord) -> None:
    """Write the robot's state before a decision."""
    record.s_before_m = robot.s
    record.command_before_mps = robot.command


@scalar
def measure_progress(record: StepRecord, robot: RobotRecord, rules: Rules) -> None:
    """Write progress and change of command, relative to the nominal speed v_n.

    progress = (s - s_before) / (v_n dt), command change = (v_c - v_c,before) / v_n
    """
    nominal = rules.nominal_speed_mps
    record.progress = (robot.s - record.s_before_m) / (nominal * rules.decision_s)
    record.command_change = (robot.command - record.command_before_mps) / nominal
