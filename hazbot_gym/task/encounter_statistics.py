"""Closest approach of recorded people to a robot, and their speeds there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.task.tracks import RecordedRobot, Recording

QUANTILES = (0.1, 0.5, 0.9)


class Approach(NamedTuple):
    """The closest approach of an encounter."""

    distance_m: float  # between centers
    robot_mps: float
    person_mps: float


class EncounterStatistics(NamedTuple):
    """Statistics of the encounters of a scenario with a robot."""

    scenario: str
    robot: str
    radius_m: float
    encounters: int
    people: int  # in an encounter, at most
    closest_m: tuple[float, ...]  # p10, p50, p90 between centers
    robot_mps: float  # median of the robot's speed there
    person_mps: float  # median of the nearest person's


def encounter_statistics(recordings: Sequence[Recording]) -> list[EncounterStatistics]:
    """Return the statistics of all recordings with a robot, by scenario and robot."""
    groups: dict[tuple[str, str], list[tuple[Recording, RecordedRobot]]] = {}
    for recording in recordings:
        if recording.robot is not None:
            key = recording.robot.scenario, recording.robot.name
            groups.setdefault(key, []).append((recording, recording.robot))
    return [_statistics(groups[key]) for key in sorted(groups)]


def _statistics(met: list[tuple[Recording, RecordedRobot]]) -> EncounterStatistics:
    approaches = [closest_approach(recording, robot) for recording, robot in met]
    robot = met[0][1]
    return EncounterStatistics(
        scenario=robot.scenario,
        robot=robot.name,
        radius_m=robot.radius_m,
        encounters=len(met),
        people=max(recording.people for recording, _ in met),
        closest_m=tuple(
            float(q) for q in np.quantile([each.distance_m for each in approaches], QUANTILES)
        ),
        robot_mps=float(np.median([each.robot_mps for each in approaches])),
        person_mps=float(np.median([each.person_mps for each in approaches])),
    )


def closest_approach(recording: Recording, robot: RecordedRobot) -> Approach:
    """Return the closest approach of any person to the robot."""
    found = []
    for first, track in zip(recording.first_steps, recording.tracks(), strict=True):
        distances = np.hypot(*(track - robot.positions[first : first + len(track)]).T)
        step = int(distances.argmin())
        found.append(
            Approach(
                float(distances[step]),
                _speed(robot.positions, first + step, recording.dt_s),
                _speed(track, step, recording.dt_s),
            )
        )
    return min(found)


def _speed(track: Floats, step: int, dt_s: float) -> float:
    """Return the speed around a step, by a central difference [m/s]."""
    before, after = max(step - 1, 0), min(step + 1, len(track) - 1)
    if before == after:
        return 0.0
    return float(np.hypot(*(track[after] - track[before])) / ((after - before) * dt_s))
