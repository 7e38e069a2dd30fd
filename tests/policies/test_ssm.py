from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.core.ssm import SsmThresholds, permitted_speed
from hazbot_gym.policies.ssm import Ssm
from hazbot_gym.task.observation import LAYOUTS

LAYOUT = LAYOUTS["tracks"]


def observed(speed_mps: float = 0.0, **people: dict[str, float]) -> npt.NDArray[np.float32]:
    """Return an observation of people; keys like ``person0``, fields without that prefix."""
    row = np.zeros(LAYOUT.width)
    values = {"speed_mps": speed_mps}
    for person, fields in people.items():
        values |= {f"{person}_{name}": value for name, value in {"present": 1.0, **fields}.items()}
    for name, value in values.items():
        i = LAYOUT.names.index(name)
        row[i] = value / LAYOUT.fields[i].scale
    return row.astype(np.float32)


def fraction(policy: Ssm, observation: Any) -> float:
    action, _ = policy.predict(observation)
    return 0.5 * (float(action[0]) + 1.0)


AHEAD = {"distance_m": 1.8, "bearing_cos": 1.0, "closing_mps": 1.2}


def test_strict_takes_everybody_for_walking_at_the_robot() -> None:
    expected = float(permitted_speed(1.8 - 0.5, SsmThresholds())) / 0.5
    for closing_mps in (-1.0, 0.0, 1.2):
        seen = observed(person0={**AHEAD, "closing_mps": closing_mps})
        assert fraction(Ssm(), seen) == pytest.approx(expected, abs=1e-5)


def test_directional_takes_the_approach_of_the_person_alone() -> None:
    near = {**AHEAD, "distance_m": 1.2}
    expected = float(permitted_speed(0.7, SsmThresholds(), 0.9)) / 0.5
    policy = Ssm("directional")  # 1.2 m/s together, of which the robot's own 0.3
    assert fraction(policy, observed(0.3, person0=near)) == pytest.approx(expected, abs=1e-4)
    away = observed(0.3, person0={**near, "closing_mps": -0.5})
    still = float(permitted_speed(0.7, SsmThresholds(), 0.0)) / 0.5
    assert fraction(policy, away) == pytest.approx(still, abs=1e-4)
    assert 0.0 < expected < still < 1.0


def test_the_strictest_of_several_people_counts_and_a_margin_adds_to_all() -> None:
    both = observed(person0=AHEAD, person1={**AHEAD, "distance_m": 1.3})
    assert fraction(Ssm(), both) < fraction(Ssm(), observed(person0=AHEAD))
    assert fraction(Ssm(margin_m=0.3), observed(person0=AHEAD)) == pytest.approx(
        float(permitted_speed(1.0, SsmThresholds())) / 0.5, abs=1e-5
    )
