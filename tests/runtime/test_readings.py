from __future__ import annotations

import math
from typing import Any

import pytest

from hazbot_gym.runtime.readings import Readings, Stop, checked, own_names
from hazbot_gym.task.observation import LAYOUTS, layout_for

LAYOUT = LAYOUTS["tracks"]
GOOD: dict[str, Any] = dict.fromkeys(own_names(LAYOUT), 0.0)


def check(
    ranges_m: Any = (1.0, 2.0, 3.0, 4.0), people: Any = (), **changes: Any
) -> Readings | Stop:
    return checked(LAYOUT, ranges_m, people, GOOD | changes, 0.5)


def test_good_readings_are_passed_on() -> None:
    found = check(people=[(1.0, 0.0, 0.0, 0.0)], speed_mps=0.4)
    assert isinstance(found, Readings)
    assert found.ranges_m == (1.0, 2.0, 3.0, 4.0)
    assert found.fields["speed_mps"] == 0.4
    assert found.people[0].x_m == 1.0


def test_ranges_are_told_by_name_and_infinity_is_no_echo() -> None:
    ranges = {"right": 1.0, "left": math.inf, "front_left": -math.inf, "front_right": 9.0}
    found = check(ranges)
    assert isinstance(found, Readings)
    assert found.ranges_m == (0.0, 9.0, 4.0, 1.0)


@pytest.mark.parametrize(
    ("cause", "named", "readings"),
    [
        ("missing", "ranges_m", {"ranges_m": None}),
        ("missing", "4", {"ranges_m": [1.0, 1.0, 1.0]}),
        ("missing", "right", {"ranges_m": {"left": 1.0, "front_left": 1.0, "front_right": 1.0}}),
        ("missing", "left", {"ranges_m": [1.0, 1.0, None, 1.0]}),
        ("not finite", "front_right", {"ranges_m": [1.0, math.nan, 1.0, 1.0]}),
        ("impossible", "front_left", {"ranges_m": [-0.1, 1.0, 1.0, 1.0]}),
        ("missing", "speed_mps", {"speed_mps": None}),
        ("not finite", "yaw_rate_radps", {"yaw_rate_radps": math.inf}),
        ("impossible", "speed_mps", {"speed_mps": 36.0}),
        ("impossible", "theta_e_rad", {"theta_e_rad": 90.0}),
        ("missing", "people", {"people": None}),
        ("not finite", "people[1].vy_mps", {"people": [(1, 0, 0, 0), (1, 0, 0, math.nan)]}),
        ("impossible", "people[0]", {"people": [(1.0, 0.0, 20.0, 0.0)]}),
        ("impossible", "vx_mps", {"people": [{"x_m": 1.0, "y_m": 0.0}]}),
        ("impossible", "'int'", {"people": 5}),
        ("impossible", "'float'", {"ranges_m": 3.0}),
        ("impossible", "'fast'", {"speed_mps": "fast"}),
    ],
)
def test_what_cannot_be_used_is_named_with_its_cause(
    cause: str, named: str, readings: dict[str, Any]
) -> None:
    found = check(**readings)
    assert isinstance(found, Stop)
    assert found.cause == cause
    assert named in found.message
    assert "\n" not in found.message


def test_tiers_without_people_or_gas_do_not_read_them() -> None:
    found = checked(LAYOUTS["sonar"], [1.0] * 4, None, GOOD, 0.5)
    assert isinstance(found, Readings)
    gas = layout_for("sonar", has_gas=True)
    stop = checked(gas, [1.0] * 4, None, GOOD, 0.5)
    assert isinstance(stop, Stop)
    assert "gas_reading" in stop.message
