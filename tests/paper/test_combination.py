from __future__ import annotations

import gymnasium
import numpy as np
import pytest

from hazbot_gym.paper.sections.combination.experiment import SCENARIO, combine
from hazbot_gym.policies.fuzzy_expert import FuzzyExpert


def test_robot_waits_for_the_human_and_goes_on_along_the_circle() -> None:
    found = combine(3)
    for events, run in zip(found.found, found.runs, strict=True):
        assert events.decelerates_s < events.stops_s < events.recovers_s
        assert events.moving_inside_s == 0.0
        assert events.least_m < 1.5  # it would have moved within 1.5 m
        assert run.position_error_m[-50:].max() < 0.005
    assert found.arrivals() == 1.0
    with_human_m, alone_m = found.largest_m(found.found[0].decelerates_s)
    assert 0.03 < with_human_m < found.largest_m()[0]  # waiting disturbs less than the start
    assert alone_m < 0.015
    assert max(found.final_m(10.0)) < 0.003
    with_human_s, alone_s = found.lap_s()
    assert with_human_s == pytest.approx(alone_s + 6.5, abs=2.0)
    assert np.ptp([run.x[-1] for run in found.runs]) > 0.0  # noise is on


def test_the_human_is_assessed_as_encountering() -> None:
    env = gymnasium.make("hazbot_gym/Corridor-v1", scenario=SCENARIO)
    observation, _ = env.reset(seed=0)
    layout, labels = env.unwrapped._layout, set()  # type: ignore[attr-defined]
    for _ in range(150):
        observation, *_ = env.step(FuzzyExpert().predict(observation)[0])
        seen = layout.decode(observation)
        labels |= {
            name
            for name in ("crossing", "encountering", "leading", "confronting")
            if seen[f"person0_{name}"] > 0.5
        }
    assert labels == {"encountering"}
