from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.fuzzy_pid import FuzzyPid
from hazbot_gym.core.pid import PLANTS
from hazbot_gym.paper.sections.circle.experiment import (
    TABLE_3,
    Figures,
    Load,
    converged_s,
    critical_points,
    drive_lap,
    figures,
    paper_drive,
    printed_errors,
)
from hazbot_gym.task.places import CIRCLE_RADIUS_M

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "tracking_circle.json").read_text(encoding="utf-8")
)
NAMES = ("max_position_m", "max_angle_rad", "position_s", "angle_s")


def run(row: dict[str, Any]) -> Figures:
    plant: Any = row["plant"]
    if "u_max" in row:
        plant = PLANTS[plant]._replace(u_max=row["u_max"])._asdict()
    fuzzy = FuzzyPid(sign=row.get("sign", -1.0))._asdict()
    tables = row.get("tables", "textbook")
    drive = paper_drive(plant=plant, wheel_loop=row["wheel_loop"], tables=tables, fuzzy=fuzzy)
    return figures(drive_lap(drive))


@pytest.mark.parametrize("row", REFERENCE["runs"], ids=lambda row: "-".join(map(str, row.values())))
def test_circle_reaches_the_published_errors_and_times(row: dict[str, Any]) -> None:
    found = run(row)

    sizes, times = [row[name] for name in NAMES[:2]], [row[name] for name in NAMES[2:]]
    assert found[:2] == pytest.approx(sizes, rel=REFERENCE["tolerance_relative"])
    assert found[2:] == pytest.approx(times, abs=REFERENCE["tolerance_s"])


@pytest.mark.parametrize("plant", ["A", "B", "A0"])
def test_fuzzy_pid_beats_pid_in_all_four_figures(plant: str) -> None:
    fuzzy = run({"plant": plant, "wheel_loop": "fuzzy_pid"})
    fixed = run({"plant": plant, "wheel_loop": "pid"})

    assert all(np.less(fuzzy, fixed))


def test_fuzzy_pid_with_the_other_sign_is_worse_than_pid() -> None:
    fuzzy = run({"plant": "A", "wheel_loop": "fuzzy_pid", "sign": 1.0})
    fixed = run({"plant": "A", "wheel_loop": "pid"})

    assert all(np.greater(fuzzy, fixed))


def test_the_environment_drives_the_same_lap() -> None:
    env = gymnasium.make("hazbot_gym/Corridor-v1", scenario="circle")
    env.reset(seed=0)
    seen = []
    for _ in range(430):
        env.step(np.ones(1))
        state = env.unwrapped.snapshot()  # type: ignore[attr-defined]
        seen.append((state.x, state.y, math.hypot(state.x_e, state.y_e), abs(state.theta_e)))
    lap = drive_lap(paper_drive())
    ours = np.stack([lap.x, lap.y, lap.position_m, lap.angle_rad], axis=1)[9:4300:10]

    assert np.array(seen) == pytest.approx(ours, abs=1e-9)


def test_an_error_has_converged_when_it_stays_below_the_band() -> None:
    time_s, error = np.arange(1.0, 6.0), np.array([0.5, 0.0, 0.002, 0.0009, 0.0])

    assert converged_s(time_s, error) == 3.0
    assert converged_s(time_s, error, band=1.0) == 0.0
    assert converged_s(time_s, np.full(5, np.nan)) == 5.0


def test_a_lap_that_diverged_has_infinite_errors() -> None:
    unstable = paper_drive(plant=PLANTS["A"]._replace(K=50.0, Tf=0.0)._asdict(), wheel_loop="pid")

    assert figures(drive_lap(unstable))[:2] == (math.inf, math.inf)


def test_a_load_slows_the_robot_from_its_time_on() -> None:
    free, loaded = drive_lap(paper_drive()), drive_lap(paper_drive(), load=Load(20.0, 1.0))
    before, after = free.time_s < 20.0, (free.time_s > 20.5) & (free.time_s < 22.0)

    assert np.array_equal(free.position_m[before], loaded.position_m[before])
    assert loaded.position_m[after].max() > free.position_m[after].max() + 0.005


def test_critical_points_lie_on_the_circle_a_quarter_apart() -> None:
    points = critical_points(drive_lap(paper_drive()))

    for point, printed in zip(points, TABLE_3, strict=True):
        assert (point.xr, point.yr) == pytest.approx((printed.xr, printed.yr), abs=0.005)
        assert math.hypot(point.xr, point.yr - CIRCLE_RADIUS_M) == pytest.approx(
            CIRCLE_RADIUS_M, abs=1e-3
        )
        assert point.position == pytest.approx(
            math.hypot(point.x - point.xr, point.y - point.yr), abs=1e-9
        )


def test_printed_table_contradicts_itself_in_three_rows() -> None:
    stated = [point.position for point in TABLE_3]
    off = np.abs(np.subtract(printed_errors(), stated))

    assert np.flatnonzero(off > 5e-4).tolist() == [1, 3, 4]
