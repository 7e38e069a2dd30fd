from __future__ import annotations

import functools
import math

import pytest

from hazbot_gym.paper.sections.meetings.experiment import Events
from hazbot_gym.paper.sections.speed_controller import experiment
from hazbot_gym.paper.sections.speed_controller.experiment import READINGS

NEVER = math.nan
NAMES = tuple(reading.name for reading in READINGS)

# Of the prototype: decelerates, stops, full recovery, seconds moving within 1.5 m; E* and C*.
# Where this environment differs, and why, is said beside the row.
SPECIFIED = {
    NAMES[0]: ((1.6, 3.7, 11.3, 0.0), (4.6, 8.5, 16.2, 0.0)),
    NAMES[1]: ((1.6, 3.7, 8.9, 0.0), (4.6, 8.5, 16.2, 0.0)),
    NAMES[2]: ((1.6, NEVER, 7.5, 3.7), (4.6, 4.6, 12.7, 0.0)),  # 13.2: braking takes 0.5 s here
    NAMES[3]: ((1.6, 4.4, 8.7, 1.2), (4.6, NEVER, 14.8, 0.0)),
    "Gaussian pattern": ((1.6, 4.1, 8.9, 0.4), (4.6, NEVER, 16.2, 0.0)),
    "Mamdani centroid": ((1.6, NEVER, 8.4, 4.6), (4.6, NEVER, 16.3, 2.4)),
    # 6.4 and 13.6 s: the same braking; it brings the robot into the human, who ends the meeting.
    "percentages are taken away": ((1.6, 1.6, 6.2, 2.5), (4.6, 4.6, NEVER, 2.0)),
    "v(t) is the present speed": ((1.6, 2.5, NEVER, 0.0), (4.6, 5.7, NEVER, 0.0)),
    # 0.6 and 2.8 s: beyond 3.6 m nobody has a pattern here, and no rule fires.
    "no limit and no shoulder at 3.0 m": ((1.6, 3.7, 9.0, 0.0), (4.6, 8.5, 16.2, 0.0)),
    "eq 8b, t = 1 s": ((1.1, 3.9, 9.2, 0.0), (3.7, NEVER, 17.4, 0.0)),
    # 2.4 and 5.6 s and never: the same 3.6 m.
    "eq 8b, t = elapsed time": ((1.1, 3.9, 9.4, 0.0), (3.5, 7.0, 26.4, 0.0)),
    "75 and 90 % of the way from 1.5 to 3.0 m": ((1.6, 3.8, 9.1, 0.0), (4.6, NEVER, 15.7, 0.0)),
    # Of the prototype only when it decelerates and stops in E* is known; the rest is as found here.
    "all terms of distance 0.25 m wide": ((1.6, 3.5, 9.0, 0.0), (4.6, 7.7, 16.3, 0.0)),
    "slow and fast divided at 0.5 m/s": ((1.6, 3.9, 9.1, 0.0), (4.6, NEVER, 15.9, 0.0)),
    # 1.5 and 2.4 s of moving within 1.5 m: whoever leaves a cone is carried on here.
    NAMES[-1]: ((1.6, 3.8, 8.2, 0.5), (7.6, 7.6, 14.7, 0.8)),
}
VERDICTS = {
    NAMES[0]: "works",
    NAMES[1]: "works",
    NAMES[2]: "unsafe",
    NAMES[3]: "unsafe",
    "Gaussian pattern": "moves within 1.5 m",
    "Mamdani centroid": "unsafe",
    "percentages are taken away": "unsafe: drives into the human",
    "v(t) is the present speed": "degenerate: never recovers",
    "no limit and no shoulder at 3.0 m": "works",
    "eq 8b, t = 1 s": "slow for",
    "eq 8b, t = elapsed time": "degenerate: slow for",
    "75 and 90 % of the way from 1.5 to 3.0 m": "works",
    "all terms of distance 0.25 m wide": "works",
    "slow and fast divided at 0.5 m/s": "works",
    NAMES[-1]: "moves within 1.5 m",
}


@functools.cache
def found(name: str) -> dict[str, Events]:
    return experiment.run(READINGS[NAMES.index(name)])


def test_every_reading_has_its_row() -> None:
    assert set(SPECIFIED) == set(VERDICTS) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_reading_comes_out_as_specified(name: str) -> None:
    for scenario, row in zip(experiment.SCENARIOS, SPECIFIED[name], strict=True):
        each = found(name)[scenario]
        here = (each.decelerates_s, each.stops_s, each.recovers_s, each.moving_inside_s)
        assert here == pytest.approx(row, abs=0.1 + 1e-9, nan_ok=True), scenario


@pytest.mark.parametrize("name", NAMES)
def test_verdict_follows_from_the_criteria(name: str) -> None:
    assert experiment.verdict(found(name)).startswith(VERDICTS[name])


def test_printed_rules_drive_into_somebody_who_comes_straight_at_the_robot() -> None:
    literal, complete = experiment.head_on().values()
    assert math.isnan(literal.decelerates_s)
    assert literal.hits == 1.0
    assert complete.hits == complete.moving_inside_s == 0.0
    assert complete.slowest_mps == 0.0


def events(**changed: float) -> Events:
    fine = Events(1.6, 3.7, 11.3, 0.8, 0.0, 0.0, 0.0, 0.0)
    return fine._replace(**changed)


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({}, "works"),
        ({"hits": 1.0, "recovers_s": NEVER}, "unsafe: drives into the human"),
        ({"moving_inside_s": 1.1}, "unsafe: moves within 1.5 m for more than 1 s"),
        ({"moving_inside_s": 1.0}, "moves within 1.5 m"),
        ({"stops_s": NEVER}, "degenerate: never stops although the human comes to 0.8 m"),
        ({"recovers_s": NEVER}, "degenerate: never recovers"),
        ({"slow_outside_s": 0.2}, "works"),
        ({"slow_outside_s": 0.3}, "slow for 0.3 s with the human beyond 3.0 m"),
        ({"slow_outside_s": 5.1}, "degenerate: slow for 5.1 s with the human beyond 3.0 m"),
    ],
)
def test_each_fault_is_named(changed: dict[str, float], fault: str) -> None:
    assert experiment.verdict({"E*": events(**changed), "C*": events()}) == fault
