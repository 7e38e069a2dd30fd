"""Leaks as they are drawn, and the walls beside a path that reflect their gas."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import Gas, make_config
from hazbot_gym.core.geometry import path_length
from hazbot_gym.core.state import GAS, Records, records
from hazbot_gym.task.fingerprint import fingerprint
from hazbot_gym.task.leak import END_M, OPEN_M, clear_gas, gas_info, sides_of
from hazbot_gym.task.places import PLACES, load_place
from hazbot_gym.task.scenario import Scenario, ScenarioSampler

SOME = 2000


def scenarios(count: int, place: str = "corridor", **gas: Any) -> list[Scenario]:
    sampler = ScenarioSampler(make_config(place=place, gas=gas, people={"count": [0, 0]}))
    return [sampler.draw(key) for key in range(count)]


def leaks(count: int, place: str = "corridor", **gas: Any) -> Records:
    """Return the leaks of scenarios that have one."""
    drawn = np.concatenate([each.gas["leak"] for each in scenarios(count, place, **gas)])
    return drawn[drawn["is_there"] == 1]


@pytest.mark.parametrize("share", [0.0, 0.2, 0.7, 1.0])
def test_share_of_episodes_with_a_leak_is_that_of_the_config(share: float) -> None:
    found = len(leaks(SOME, leak_share=share))
    assert abs(found - share * SOME) <= 4.0 * math.sqrt(share * (1.0 - share) * SOME)


def test_without_a_leak_its_record_is_blank() -> None:
    for each in scenarios(5, leak_share=0.0):
        assert each.gas.tobytes() == records(GAS, 1).tobytes()


def test_without_gas_there_is_no_record() -> None:
    assert len(ScenarioSampler(make_config()).draw(1).gas) == 0


@pytest.mark.parametrize("place", PLACES)
def test_leaks_lie_beside_the_path_within_the_walls(place: str) -> None:
    drawn, where = leaks(400, place, leak_share=1.0), load_place(place)
    left_m, right_m = sides_of(where)
    last_m = path_length(where.path.view(np.recarray)) - END_M

    assert (drawn["left_m"] == left_m).all()
    assert (drawn["right_m"] == right_m).all()
    for values, low, high in (
        (drawn["s_m"], END_M, last_m),
        (drawn["y_m"], -min(right_m, OPEN_M), min(left_m, OPEN_M)),
    ):
        assert values.min() == pytest.approx(low, abs=0.03 * (high - low))
        assert values.max() == pytest.approx(high, abs=0.03 * (high - low))
        assert low <= values.min() < values.max() <= high
        assert values.mean() == pytest.approx(0.5 * (low + high), abs=0.06 * (high - low))


def test_strength_is_log_uniform_within_its_range() -> None:
    strength = leaks(SOME, leak_share=1.0, strength_ppm=[2.0, 200.0])["strength_ppm"]
    assert 2.0 <= strength.min() < 2.1
    assert 190.0 < strength.max() <= 200.0
    assert np.median(strength) == pytest.approx(20.0, rel=0.15)


def test_draught_blows_both_ways_at_a_uniform_speed() -> None:
    draught = leaks(SOME, leak_share=1.0, draught_mps=[0.2, 0.5])["draught_mps"]
    speeds = np.abs(draught)
    assert 0.2 <= speeds.min() < 0.205
    assert 0.495 < speeds.max() <= 0.5
    assert np.mean(draught > 0.0) == pytest.approx(0.5, abs=0.05)
    for way in (1.0, -1.0):
        assert speeds[draught * way > 0.0].mean() == pytest.approx(0.35, abs=0.01)


def test_a_range_of_one_value_gives_that_value() -> None:
    drawn = leaks(20, leak_share=1.0, strength_ppm=[7.0, 7.0], draught_mps=[0.3, 0.3])
    assert drawn["strength_ppm"] == pytest.approx(7.0)
    assert np.abs(drawn["draught_mps"]) == pytest.approx(0.3)


def test_equal_keys_have_equal_leaks_whatever_the_people() -> None:
    crowd = ScenarioSampler(make_config(gas={}, people={"count": [6, 6]}))
    for key, alone in enumerate(scenarios(20)):
        assert crowd.draw(key).gas.tobytes() == alone.gas.tobytes()


def test_scenarios_that_differ_in_the_leak_have_other_fingerprints() -> None:
    one, other = (scenarios(1, leak_share=1.0, strength_ppm=[s, s])[0] for s in (5.0, 6.0))
    assert (
        len({fingerprint(one), fingerprint(other), fingerprint(one._replace(gas=one.gas[:0]))}) == 3
    )


def test_gas_of_an_ended_episode_is_cleared_entirely() -> None:
    full = np.frombuffer(np.random.default_rng(0).bytes(GAS.itemsize), GAS).copy()
    clear_gas(full.view(np.recarray)[0])
    assert all(np.all(each == 0) for name in ("leak", "smell") for each in full[name][0].tolist())
    assert full["is_reported"] == full["false_alarms"] == 0


# --- walls beside the path -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "options", "expected"),
    [
        ("corridor", {"width_m": 3.0}, (1.5, 1.5)),
        ("doorway", {"width_m": 3.0, "door_m": 1.0}, (1.5, 1.5)),  # a short narrow
        ("aisle", {"width_m": 2.0}, (1.0, 1.0)),  # around a corner
        ("open", {}, (math.inf, math.inf)),
        ("circle", {}, (math.inf, math.inf)),
    ],
)
def test_sides_of_a_place_are_the_walls_along_most_of_its_path(
    place: str, options: dict[str, float], expected: tuple[float, float]
) -> None:
    assert sides_of(load_place(place, options)) == pytest.approx(expected)


def test_a_short_wall_on_one_side_counts_for_nothing_and_a_long_one_for_all(tmp_path: Any) -> None:
    text = "{{name: shed, walls: [[{}, 1, {}, 1]], path: {{points: [[0, 0], [12, 0]]}}}}"
    for first, last, left_m in ((5, 6, math.inf), (2, 11, 1.0), (11, 2, 1.0)):
        file = tmp_path / "shed.yaml"
        file.write_text(text.format(first, last))
        assert sides_of(load_place(str(file))) == (left_m, math.inf)


# --- info ----------------------------------------------------------------------------------------


def test_info_says_how_far_ahead_the_leak_is_and_nothing_of_one_that_is_not_there() -> None:
    gas = records(GAS, 2)
    gas["smell"]["s_m"] = 5.0
    gas["leak"]["is_there"][0], gas["leak"]["s_m"][0] = 1, 7.5
    told = gas_info(gas)
    assert told["leak"].tolist() == [1, 0]
    assert told["leak_distance_m"].tolist() == [2.5, 0.0]
    told["leak"][:] = 9
    assert gas["leak"]["is_there"].tolist() == [1, 0]


def test_defaults_are_as_documented() -> None:
    assert Gas() == Gas.model_validate({})
    assert make_config(gas={}).gas == Gas()
    assert make_config().gas is make_config(gas=None).gas is None
