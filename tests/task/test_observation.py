from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.sensor_ring import RINGS, RangeSensor, Ring
from hazbot_gym.core.state import (
    CONFRONTING,
    CROSSING,
    GAS,
    LEADING,
    NO_PATTERN,
    ROBOT,
    TRACK,
    Floats,
    Records,
    records,
)
from hazbot_gym.task.observation import (
    GAS_FIELDS,
    KNOWN,
    LAYOUTS,
    PERSON_FIELDS,
    PERSON_SLOTS,
    TIERS,
    TRACKER_RANGE_M,
    Layout,
    layout_for,
    layout_in,
    layout_of,
    markdown_table,
    observe_kernel,
    observing,
    selected,
)
from tests.refusals import refused

LAYOUT = LAYOUTS["tracks"]
PATH = straight_path(np.array([[0.0, 0.0], [7.0, 0.0], [7.0, 7.0]]), 1.0)
LENGTH_M = 12.0 + math.pi / 2.0
OWN = {"v": 0.4, "omega": -0.3, "command": 0.375, "x_e": -0.1, "y_e": 0.05, "theta_e": -0.2}


def a_robot(**fields: float) -> Records:
    robot = records(ROBOT, 1)
    for name, value in {"x": 1.0, "y": 2.0, "theta": 0.5, "s": 5.5, **OWN, **fields}.items():
        robot[name] = value
    return robot


def seen(*people: dict[str, Any]) -> Records:
    """Return tracks of people, visible unless said otherwise, placed relative to the robot."""
    tracks = records(TRACK, len(people))
    for track, person in zip(tracks, people, strict=True):
        fields = {"visible": 1, "pattern": NO_PATTERN, **person}
        for name, value in fields.items():
            track[name] = value
    return tracks


def at(distance_m: float, bearing_deg: float = 0.0, **fields: Any) -> dict[str, Any]:
    """Return the place of somebody seen by ``a_robot()``."""
    direction = 0.5 + math.radians(bearing_deg)
    x, y = 1.0 + distance_m * math.cos(direction), 2.0 + distance_m * math.sin(direction)
    return {"x": x, "y": y, **fields}


def observation_of(
    robot: Records | None = None,
    tracks: Records | None = None,
    ranges: Floats | None = None,
    layout: Layout = LAYOUT,
    gas: Records | None = None,
) -> npt.NDArray[np.float32]:
    out = np.full(layout.width, np.nan, dtype=np.float32)
    ranges = np.array([0.5, 1.0, 2.0, 4.0]) if ranges is None else ranges
    robot = a_robot() if robot is None else robot
    tracks, gas = seen() if tracks is None else tracks, records(GAS, 0) if gas is None else gas
    observe_kernel(robot, PATH, ranges, tracks, gas, out)
    return out


def decoded(*arguments: Any, **keywords: Any) -> dict[str, float]:
    fields = LAYOUT.decode(observation_of(*arguments, **keywords))
    return {name: float(value) for name, value in fields.items()}


def test_robots_own_fields_come_back_in_their_units() -> None:
    fields = decoded()

    expected = {
        "range_front_left_m": 0.5,
        "range_front_right_m": 1.0,
        "range_left_m": 2.0,
        "range_right_m": 4.0,
        "speed_mps": OWN["v"],
        "yaw_rate_radps": OWN["omega"],
        "command_mps": OWN["command"],
        "x_e_m": OWN["x_e"],
        "y_e_m": OWN["y_e"],
        "theta_e_rad": OWN["theta_e"],
        "remaining_m": LENGTH_M - 5.5 + 0.1,
        "curvature_ahead_per_m": 1.0,  # s = 6.5, in the corner
    }
    assert LAYOUT.names[: len(expected)] == tuple(expected)
    assert {name: fields[name] for name in expected} == pytest.approx(expected, rel=2e-7)


def test_persons_fields_come_back_in_their_units() -> None:
    # 4 m away, 60 deg to the left, walking at 1.5 m/s to where the robot came from.
    heading = 0.5 + math.pi
    velocity = {"vx": 1.5 * math.cos(heading), "vy": 1.5 * math.sin(heading)}
    fields = decoded(tracks=seen(at(4.0, 60.0, pattern=LEADING, **velocity)))

    expected = {
        "present": 1.0,
        "distance_m": 4.0,
        "bearing_sin": math.sin(math.pi / 3.0),
        "bearing_cos": 0.5,
        "speed_mps": 1.5,
        "across_mps": 1.5 * math.sin(math.pi / 3.0),
        "closing_mps": 1.9 * 0.5,  # of 1.5 + 0.4 m/s
        "time_to_closest_s": 2.0 / 1.9,
        "closest_m": 4.0 * math.sin(math.pi / 3.0),
        "crossing": 0.0,
        "encountering": 0.0,
        "leading": 1.0,
        "confronting": 0.0,
    }
    names = tuple(f"person0_{name}" for name in expected)
    assert LAYOUT.names[12:25] == names
    assert tuple(field.name for field in PERSON_FIELDS) == tuple(expected)
    assert [fields[name] for name in names] == pytest.approx([*expected.values()], rel=2e-6)


def test_people_are_sorted_by_distance_and_only_the_nearest_are_kept() -> None:
    tracks = seen(
        at(5.0), at(1.0, visible=0), at(2.0, 90.0), at(4.0, -90.0), at(3.0), at(7.0), at(6.0)
    )
    fields = decoded(tracks=tracks)

    distances = [fields[f"person{i}_distance_m"] for i in range(PERSON_SLOTS)]
    assert distances == pytest.approx([2.0, 3.0, 4.0])
    assert fields["person0_bearing_sin"] == pytest.approx(1.0)
    assert fields["person2_bearing_sin"] == pytest.approx(-1.0)


def test_two_at_the_same_distance_both_appear() -> None:
    same = {**at(3.0), "pattern": CROSSING}
    fields = decoded(tracks=seen(same, {**same, "pattern": CONFRONTING}))

    assert [fields["person0_crossing"], fields["person1_confronting"]] == [1.0, 1.0]
    assert fields["person2_present"] == 0.0


def test_empty_slot_is_nobody_far_away_and_never_met() -> None:
    fields = decoded(tracks=seen(at(2.0, visible=0)))

    far = {"distance_m": 8.0, "time_to_closest_s": 8.0, "closest_m": 8.0}
    for i in range(PERSON_SLOTS):
        slot = {f.name: fields[f"person{i}_{f.name}"] for f in PERSON_FIELDS}
        assert slot == {f.name: far.get(f.name, 0.0) for f in PERSON_FIELDS}


def test_somebody_on_the_robots_own_spot_is_finite() -> None:
    assert np.isfinite(observation_of(tracks=seen(at(0.0)))).all()


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_values_beyond_their_bounds_are_clipped_to_the_observation_space(sign: float) -> None:
    robot = a_robot(**{name: sign * 1e3 for name in (*OWN, "s")})
    velocity = {"vx": -sign * 1e3, "vy": 0.0}
    tracks = seen(at(100.0, **velocity), at(-100.0, **velocity), at(0.1, **velocity))
    observation = observation_of(robot, tracks, ranges=np.full(4, sign * 1e3))

    assert (observation >= LAYOUT.low).all()
    assert (observation <= LAYOUT.high).all()
    bounds = LAYOUT.high if sign > 0.0 else LAYOUT.low
    assert observation[:7].tolist() == bounds[:7].tolist()


def test_tier_without_people_is_the_beginning_of_the_others() -> None:
    sonar = LAYOUTS["sonar"]

    assert sonar.names == LAYOUT.names[:12]
    assert not any(name.startswith("person") for name in sonar.names)
    assert LAYOUTS["privileged"].names == LAYOUT.names
    full = observation_of(tracks=seen(at(2.0)))
    assert observation_of(tracks=seen(at(2.0)), layout=sonar).tolist() == full[:12].tolist()


def smelling(**fields: Any) -> Records:
    gas = records(GAS, 1)
    for name, value in fields.items():
        gas["smell"][name] = value
    return gas


@pytest.mark.parametrize("tier", LAYOUTS)
def test_gas_sensor_stands_before_people_and_moves_nothing_else(tier: str) -> None:
    people, with_gas = seen(at(2.0, 40.0, pattern=LEADING)), layout_for(tier, has_gas=True)
    past = 0.1 * np.arange(1, 11)
    gas = smelling(
        reading=9.0, smooth=0.6, smoother=0.4, since_peak_s=3.0, has_sounded=1, past=past
    )
    fields = with_gas.decode(observation_of(tracks=people, gas=gas, layout=with_gas))

    assert with_gas.names[12 : 12 + len(GAS_FIELDS)] == tuple(field.name for field in GAS_FIELDS)
    smelt = {"gas_reading": 0.6, "gas_rate_per_s": 0.2, "gas_since_peak_s": 3.0, "gas_alarmed": 1.0}
    smelt |= {f"gas_reading_{k}s": 0.1 * k for k in range(1, 11)}
    assert {name: fields.pop(name) for name in smelt} == pytest.approx(smelt)
    assert fields == LAYOUTS[tier].decode(observation_of(tracks=people, layout=LAYOUTS[tier]))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_readings_beyond_their_bounds_are_clipped(sign: float) -> None:
    layout = layout_for("tracks", has_gas=True)
    gas = smelling(smooth=sign * 1e3, smoother=-sign * 1e3, since_peak_s=1e3)
    observation = observation_of(gas=gas, layout=layout)

    assert (observation >= layout.low).all()
    assert (observation <= layout.high).all()


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("ring", RINGS)
def test_an_observation_without_its_gas_sensor_is_that_of_the_layout_without(
    tier: str, ring: Ring
) -> None:
    with_gas, without = (layout_for(tier, ring, has_gas=has) for has in (True, False))
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, (5, with_gas.width)).astype(np.float32)
    rest = selected(rows, without)

    assert layout_of(rest) is layout_of(np.zeros(without.width))
    kept = [with_gas.names.index(name) for name in without.names]
    assert np.array_equal(rest, rows[:, kept])
    assert selected(rest, without) is rest


@pytest.mark.parametrize("tier", LAYOUTS)
def test_layout_agrees_with_the_table_of_fields(tier: str) -> None:
    layout = LAYOUTS[tier]

    assert layout.width == len(layout.names) == len(layout.fields) == len(set(layout.names))
    assert (layout.low < layout.high).all()
    wide = {name for name, high in zip(layout.names, layout.high, strict=True) if high > 1.0}
    closing = {f"person{i}_closing_mps" for i in range(layout.person_slots)}
    assert wide == {"speed_mps", "yaw_rate_radps", "command_mps", *closing}


def test_decoding_keeps_leading_axes() -> None:
    batch = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 2, LAYOUT.width))
    fields = LAYOUT.decode(batch)

    assert fields["remaining_m"].shape == (5, 2)
    single = LAYOUT.decode(batch[3, 1])
    assert {name: float(values[3, 1]) for name, values in fields.items()} == single


def test_each_sensor_of_a_ring_adds_a_range_and_moves_the_rest() -> None:
    people, six = seen(at(2.0, 40.0, pattern=LEADING)), layout_for("tracks", "six")
    ranges = np.array([0.5, 1.0, 2.0, 4.0, 3.0, 5.0])
    fields = six.decode(observation_of(tracks=people, ranges=ranges, layout=six))

    assert six.names[4:7] == ("range_diagonal_left_m", "range_diagonal_right_m", "speed_mps")
    assert fields.pop("range_diagonal_left_m") == 3.0
    assert fields.pop("range_diagonal_right_m") == 4.0  # clipped
    assert fields == decoded(tracks=people)
    assert six.low[:6].tolist() == [0.0] * 6


def test_a_ring_of_ones_own_is_read_where_its_environment_is_named() -> None:
    ring = RangeSensor("ahead", 0.0), RangeSensor("behind", 3.0)
    config = make_config(sensors={"ring": ring})
    tracks = layout_in(config)

    assert tracks.names == ("range_ahead_m", "range_behind_m", *LAYOUT.names[4:])
    with observing(config):
        assert layout_of(np.zeros(tracks.width)) is tracks
        assert layout_of(np.zeros(10)).names == tracks.names[:10]
        with refused("12 ... allowed ... 10 ... sonar ... 2"):
            layout_of(np.zeros(12))
    with refused(f"{tracks.width} ... observing"):
        layout_of(np.zeros(tracks.width))


@pytest.mark.parametrize("slots", [1, 2, 5, 64])
def test_person_slots_are_read_where_their_environment_is_named(slots: int) -> None:
    config = make_config(person_slots=slots)
    layout = layout_in(config)

    assert layout.width == LAYOUT.width + (slots - PERSON_SLOTS) * len(PERSON_FIELDS)
    assert sum(name.endswith("_present") for name in layout.names) == slots
    with observing(config):
        assert layout_of(np.zeros(layout.width)) is layout
        with refused(f"{LAYOUT.width} ... {slots} people"):
            layout_of(np.zeros(LAYOUT.width))
    with refused(f"{layout.width} ... person_slots"):
        layout_of(np.zeros(layout.width))


def test_more_slots_hold_the_next_nearest_people() -> None:
    people = seen(*(at(float(distance), 10.0) for distance in (3, 1, 4, 2, 5)))
    for slots in (1, 3, 5, 7):
        layout = layout_for("tracks", person_slots=slots)
        fields = layout.decode(observation_of(tracks=people, layout=layout))
        there = [round(float(fields[f"person{i}_distance_m"]), 6) for i in range(slots)]
        assert there == [1.0, 2.0, 3.0, 4.0, 5.0, TRACKER_RANGE_M, TRACKER_RANGE_M][:slots]
        fewer = layout_for("tracks", person_slots=1)
        same = fewer.decode(observation_of(tracks=people, layout=fewer))
        assert {name: fields[name] for name in fewer.names} == same


def test_an_observation_that_would_be_taken_for_another_one_is_refused() -> None:
    ring = [{"name": f"s{i}", "angle_rad": 0.1 * i} for i in range(5)]
    with refused("person_slots ... 4 ... 5 range sensors ... gas"):
        layout_in(make_config(sensors={"ring": ring}, person_slots=4))


def test_contexts_end_where_they_began() -> None:
    config = make_config(person_slots=5)
    with observing(config), pytest.raises(ZeroDivisionError), observing(make_config()):
        _ = 1 / 0
    assert layout_of(np.zeros(LAYOUT.width)) is LAYOUT


def test_an_environment_in_the_place_of_its_config_is_refused() -> None:
    env: Any = object()
    with refused("config: given ... allowed is env.unwrapped.config"), observing(env):
        pass


@pytest.mark.parametrize("shape", [(12,), (7, 12), (14,), (51,), (2, 3, 51), (53,), (26,), (3, 65)])
def test_layout_is_told_by_the_last_axis(shape: tuple[int, ...]) -> None:
    assert layout_of(np.zeros(shape)).width == shape[-1]


def test_no_two_rings_of_a_config_have_observations_of_one_size_but_other_fields() -> None:
    """A policy knows nothing of an observation but its size."""
    known: dict[int, Any] = {}
    for count, has_gas, tier in itertools.product(range(1, 17), (False, True), ("sonar", "tracks")):
        sensors = [{"name": f"s{i}", "angle_rad": 0.1 * i} for i in range(count)]
        ring = {4: "paper", 6: "six"}.get(count, sensors)
        config = make_config(tier=tier, sensors={"ring": ring}, gas={} if has_gas else None)
        layout = layout_in(config)
        if layout.width in KNOWN:
            assert layout.names == KNOWN[layout.width].names
            known[layout.width] = layout
    assert set(known) == set(KNOWN)


@pytest.mark.parametrize("shape", [(), (13,), (51, 1)])
def test_observation_of_another_width_is_refused(shape: tuple[int, ...]) -> None:
    with refused("12 ... sonar ... 51 ... tracks"):
        layout_of(np.zeros(shape))


def test_table_for_the_docs_has_a_row_for_each_entry() -> None:
    head, rule, *rows = markdown_table("sonar").split("\n")

    assert head.count("|") == rule.count("|") == 7
    assert len(rows) == 12
    assert rows[0] == "| 0 | range_front_left_m | 0 | 1 | 4 m | ultrasonic, front left |"
    assert rows[7] == ("| 7 | x_e_m | -1 | 1 | 0.5 m | along-track error, actual minus reference |")
    assert len(markdown_table().split("\n")) == 2 + LAYOUT.width
