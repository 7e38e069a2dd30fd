"""Details that the paper leaves open, against an earlier prototype (docs/paper.md, section 5.2)."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.paper.sections.circle.experiment import (
    BAND,
    NOISE,
    START,
    Figures,
    Lap,
    drive_lap,
    paper_drive,
    reported_figures,
)
from hazbot_gym.paper.sections.circle.variants import (
    LOOPS,
    bands,
    noisy,
    noisy_laps,
    plants,
    steady_state_ratio,
    variants,
)
from hazbot_gym.task.places import CIRCLE_RADIUS_M

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "tracking_circle.json").read_text(encoding="utf-8")
)


@functools.cache
def changed() -> dict[str, Figures]:
    return variants()


@functools.cache
def unchanged() -> dict[str, Figures]:
    return plants()


@pytest.mark.parametrize("name", REFERENCE["variants"])
def test_one_thing_changed_gives_the_prototype_s_figures(name: str) -> None:
    found, known = changed()[name], REFERENCE["variants"][name]

    assert found[:2] == pytest.approx(known[:2], rel=REFERENCE["tolerance_relative"])
    assert found[2:] == pytest.approx(known[2:], abs=REFERENCE["tolerance_s"])


def test_a_reference_that_speeds_up_leaves_a_smaller_error() -> None:
    found = changed()["reference speeds up at 0.5 m/s², fuzzy-PID"]

    assert found[:2] == pytest.approx(REFERENCE["ramp_1_s"], rel=REFERENCE["tolerance_relative"])
    assert found.position_max_m < unchanged()["B, fuzzy-PID"].position_max_m


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize(
    ("change", "percent"),
    # The prototype: 0.2 and 3 percent; here it is up to 0.7 and 4.2 (docs/paper.md, section 5.2).
    [("radius 3.5 m", 1.0), ("steps of 0.005 s", 3.0), ("steps of 0.02 s", 5.0)],
)
def test_radius_and_sampling_matter_by_percents(loop: str, change: str, percent: float) -> None:
    found, known = changed()[f"{change}, {loop}"], unchanged()[f"B, {loop}"]

    assert found == pytest.approx(known, rel=0.01 * percent)
    assert found != known


def test_the_other_sign_of_the_rules_is_worse_than_no_rules_and_symmetric_tables_are_not() -> None:
    wrong = changed()["rules see wanted minus actual (s = +1), fuzzy-PID"]
    symmetric, pid = changed()["symmetric tables, fuzzy-PID"], unchanged()["B, PID"]

    assert all(a > b for a, b in zip(wrong, pid, strict=True))
    assert all(a < b for a, b in zip(symmetric, pid, strict=True))


@pytest.mark.parametrize("loop", LOOPS)
def test_times_of_convergence_hang_on_the_band(loop: str) -> None:
    found = bands(drive_lap(paper_drive(wheel_loop=LOOPS[loop])))

    for band, known in REFERENCE["bands"].items():
        assert found[band] == pytest.approx(known[loop], abs=REFERENCE["bands_tolerance_s"]), band
    assert found[f"{BAND:g}"] == pytest.approx(unchanged()[f"B, {loop}"][2:])


def test_at_two_percent_of_the_largest_error_the_fuzzy_pid_converges_no_sooner() -> None:
    fuzzy, fixed = (
        bands(drive_lap(paper_drive(wheel_loop=loop)))["2% of the largest"]
        for loop in LOOPS.values()
    )

    assert fuzzy.position_s > fixed.position_s


def test_noise_leaves_the_largest_error_and_takes_the_third_decimal() -> None:
    found = noisy(noisy_laps("fuzzy_pid", 20))
    largest, time_s = found.spreads["position_max_m"], found.spreads["position_converged_s"]

    assert largest.low <= largest.median <= largest.high
    assert largest.median == pytest.approx(unchanged()["B, fuzzy-PID"].position_max_m, rel=0.01)
    assert time_s.high - time_s.low > 1.0
    assert 1e-4 < found.spreads["position_left_m"].median < BAND


def lap_with_error(early_m: float, late_m: float) -> Lap:
    time_s = np.arange(0.1, 40.0, 0.1)
    error = np.where(time_s > 20.0, late_m, early_m)
    return Lap(time_s, *(np.zeros_like(time_s) for _ in range(4)), error, error)


def test_steady_state_errors_are_compared_late_in_the_lap_and_by_seed() -> None:
    fuzzy = [lap_with_error(9.0, late_m) for late_m in (0.5, 1.0, 4.0)]
    fixed = [lap_with_error(1.0, late_m) for late_m in (1.0, 2.0, 8.0)]

    assert steady_state_ratio(fuzzy, fixed) == pytest.approx((0.5, 0.5, 0.5))


def test_the_paper_s_bounds_hold_on_plant_a_and_not_on_plant_b() -> None:
    bounds = reported_figures("fuzzy-PID")[:2]

    assert all(np.less(unchanged()["A, fuzzy-PID"][:2], bounds))
    assert not any(np.less(unchanged()["B, fuzzy-PID"][:2], bounds))


def test_noise_of_the_circle_is_that_of_table_2() -> None:
    # 0.002 m/s at a wheel of 0.2 m, and 0.002 rad (docs/paper.md, section 5.1a).
    assert NOISE == {"wheel_noise_radps": 0.01, "heading_noise_rad": 0.002}


def test_the_circle_is_that_of_table_3_and_starts_where_the_paper_says() -> None:
    assert REFERENCE["radius_m"] == CIRCLE_RADIUS_M
    assert START == (0.0, 0.0, 0.0)
