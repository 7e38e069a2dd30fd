"""Episode record, independent of the engine."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config, Gas
from hazbot_gym.core.gas_sensor import gas_sensor_of
from hazbot_gym.core.state import Floats, Ints, Records
from hazbot_gym.task.fingerprint import fingerprint
from hazbot_gym.task.outcome import CAUSE_NAMES, NOBODY, OUTCOME_NAMES, RUNNING, TIMEOUT
from hazbot_gym.task.scenario import ScenarioSampler
from hazbot_gym.utils.json_object import JsonObject

# Columns of ``Episode.people``, by the names of the fields of ``core.state.PERSON``.
PERSON_COLUMNS = ("x", "y", "vx", "vy", "radius")
# Keys of the last info that describe the end of an episode.
ENDING = ("outcome", "contact_caused_by", "contact_speed_mps")
X, Y, VX, VY, RADIUS = range(5)


class Episode(NamedTuple):
    """One recorded episode: T + 1 decision instants, the start included, and T decisions.

    Attributes:
        time_s: (T + 1,) simulated time [s].
        pose: (T + 1, 3) x [m], y [m], heading [rad] of the robot.
        speed_mps: (T + 1,) actual speed along the heading [m/s].
        command_mps: (T + 1,) speed commanded by the policy [m/s].
        pose_error: (T + 1, 3) x_e [m], y_e [m], theta_e [rad], actual minus reference, robot frame.
        people: (T + 1, K, 5) x, y [m], vx, vy [m/s] and radius [m] of each person; NaN while
            absent.
        people_alone: (T + 1, K, 2) counterfactual positions of the same people without the robot
            [m]; NaN where absent or unknown.
        rewards: (T,) reward of each decision.
        reward_terms: unweighted terms of the reward, (T,) each.
        costs: (T,) safety cost of each decision.
        outcome: ``arrived``, ``contact_person``, ``contact_wall`` or ``timeout``.
        contact_caused_by: ``robot``, ``person`` or empty.
        contact_speed_mps: relative speed at the contact [m/s], NaN without one.
        time_free_s: time of the same path without people under the same drive limits [s].
        horizon_s: time at which an episode is cut off [s].
        robot_radius_m: radius of the robot [m].
        deceleration_mps2: limit of the drive's deceleration [m/s^2].
        nominal_mps: nominal speed, that of action +1 [m/s].
        sensor_rise_s: time constant of the gas sensor's rise [s]; without gas, of the default one.
        gas: (T + 1,) GAS records; (0,) without gas.
    """

    time_s: Floats
    pose: Floats
    speed_mps: Floats
    command_mps: Floats
    pose_error: Floats
    people: Floats
    people_alone: Floats
    rewards: Floats
    reward_terms: dict[str, Floats]
    costs: Floats
    outcome: str
    contact_caused_by: str
    contact_speed_mps: float
    time_free_s: float
    horizon_s: float
    robot_radius_m: float
    deceleration_mps2: float
    nominal_mps: float
    sensor_rise_s: float
    gas: Records


def rise_s_of(config: Config) -> float:
    """Return the time constant of the rise of an environment's gas sensor [s]."""
    return gas_sensor_of((config.gas or Gas()).sensor).rise_s


def labels_of(source: ScenarioSampler, key: int) -> dict[str, str]:
    """Return the labels of a scenario: its key, its place, and a hash of all drawn values."""
    scenario = source.draw(key)
    return {
        "scenario_key": str(key),
        "place": scenario.name,
        "scenario_hash": fingerprint(scenario),
    }


def ending(outcome: str, caused_by: str, speed_mps: float) -> JsonObject:
    """Return an episode's ``ENDING`` from its last info; one cut off from outside has timed out."""
    has_touched = caused_by != CAUSE_NAMES[NOBODY]
    return {
        "outcome": OUTCOME_NAMES[TIMEOUT] if outcome == OUTCOME_NAMES[RUNNING] else outcome,
        "contact_caused_by": caused_by if has_touched else "",
        "contact_speed_mps": float(speed_mps) if has_touched else np.nan,
    }


def stack_people(instants: Ints, persons: Ints, people: Floats, count: int) -> tuple[Ints, Floats]:
    """Return the numbers (K,) of all people ever present, and ``Episode.people`` (count, K, 5).

    Args:
        instants: (M,) instant of each row.
        persons: (M,) number of the person.
        people: (M, 5) state of that person at that instant.
        count: number of instants.
    """
    seen, columns = np.unique(persons, return_inverse=True)  # people never present have no column
    stacked = np.full((count, len(seen), len(PERSON_COLUMNS)), np.nan)
    stacked[instants, columns] = people
    return seen, stacked
