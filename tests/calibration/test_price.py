from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.calibration import price as model
from hazbot_gym.calibration.price import (
    BEHAVIOURS,
    Drive,
    break_even,
    costs,
    drives_of,
    excess,
    revealed,
)
from hazbot_gym.core.discomfort import discomfort
from hazbot_gym.core.state import PERSON_RADIUS_M
from hazbot_gym.task.track_formats.encounters import read_encounters
from hazbot_gym.utils.files import read_json
from tests.encounter_rows import rows, written

RECORD = Path(__file__).parents[2] / "benchmarks" / "encounters.json"
GROUP = ("crossing", "hsr")


def drive(
    behaviour: str = "compliant", *, price: float = 4.0, delay_s: float = 0.0, felt_s: float = 0.0
) -> Drive:
    """Return a drive at optimal speeds for a price, past a person."""
    nearness = np.exp(-((np.linspace(-4.0, 4.0, 200)) ** 2))
    share = 1.0 / np.sqrt(np.maximum(price * nearness, 1.0))
    return Drive(GROUP, behaviour, 0.1, delay_s, felt_s, nearness, share)


@pytest.mark.parametrize("price", [model.PRICES[k] for k in (40, 64, 90)])
def test_optimal_speeds_reveal_their_price(price: float) -> None:
    table = costs([drive(price=price)])
    assert revealed(table) == pytest.approx(price)
    assert excess(table).min() == pytest.approx(1.0)
    assert np.all(excess(table) >= 1.0 - 1e-12)


def test_break_even_is_the_price_of_equal_costs() -> None:
    careful = [drive(delay_s=delay, felt_s=0.5) for delay in (3.0, 5.0)]
    others = [drive("noncompliant", delay_s=1.0, felt_s=felt) for felt in (1.0, 2.0)]
    assert break_even([*careful, *others]) == pytest.approx(3.0 / 1.0)
    assert break_even([*careful, *(each._replace(felt_s=0.1) for each in others)]) is None
    apart = [each._replace(group=("frontal", "hsr")) for each in others]
    assert break_even([*careful, *apart]) is None


def test_price_without_bound_is_missing_in_the_record() -> None:
    record = model.report([drive(felt_s=0.5), drive("noncompliant", felt_s=0.1)])
    assert record is not None
    assert record["break_even"] == {"value": None, "interval": [None, None]}


def test_drive_at_constant_speed_has_no_delay_and_its_discomfort(tmp_path: Path) -> None:
    (recording,) = read_encounters(written(tmp_path / "met.csv", rows(lateral_m=0.8)))
    (driven,) = drives_of([recording])
    assert driven.delay_s == pytest.approx(0.0, abs=0.2)  # smoothed at both ends
    assert recording.robot is not None
    clearance_m = 0.8 - recording.robot.radius_m - PERSON_RADIUS_M
    assert driven.nearness.max() > discomfort(clearance_m, 0.0)
    assert driven.felt_s == pytest.approx(float(driven.nearness.sum()) * 0.1, rel=0.05)


def test_slower_drive_has_more_delay_and_less_discomfort_in_motion(tmp_path: Path) -> None:
    fast = rows(scene=1)
    slow = rows(scene=2)
    for k, line in enumerate(slow):
        cells = line.split(",")
        if cells[6] == "robot":
            cells[7] = f"{0.5 * float(cells[7]):.3f}"
        slow[k] = ",".join(cells)
    first, second = drives_of(read_encounters(written(tmp_path / "met.csv", fast + slow)))
    assert second.delay_s > first.delay_s + 2.0
    assert second.felt_s < first.felt_s


def test_report_needs_both_behaviours() -> None:
    assert model.report([drive()]) is None
    both = [drive(each, delay_s=2.0 - k, felt_s=1.0 + k) for k, each in enumerate(BEHAVIOURS)]
    record = model.report(both)
    assert record is not None
    assert record["break_even"]["value"] == pytest.approx(1.0)
    low, high = record["break_even"]["interval"]
    assert low <= 1.0 <= high


def test_record_is_the_price_of_the_recorded_drives(tracks_dir: Path) -> None:
    kept = read_json(RECORD)["price"]
    drives = drives_of(read_encounters(tracks_dir / "robot_encounters" / "dev.csv"))
    assert len(drives) == kept["drives"]
    assert break_even(drives) == pytest.approx(kept["break_even"]["value"])
    slow = [each for each in drives if each.behaviour == "compliant"]
    assert revealed(costs(slow)) == kept["revealed"]["value"]
