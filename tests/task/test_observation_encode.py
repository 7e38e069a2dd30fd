"""Encoding by name, the reverse of decoding."""

from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.core.state import CROSSING, NO_PATTERN, ROBOT, TOP_SPEED_MPS, TRACK, records
from hazbot_gym.task.observation import LAYOUTS, PERSON_SLOTS, layout_for, person_fields
from tests.refusals import refused

ALL = [
    layout_for(tier, ring, has_gas=gas)
    for tier in ("sonar", "tracks")
    for ring in ("paper", "six")
    for gas in (False, True)
]


@pytest.mark.parametrize("layout", ALL, ids=lambda layout: str(layout.width))
def test_what_is_decoded_is_encoded_to_the_same_bits(layout: object) -> None:
    rng = np.random.default_rng(0)
    low, high = layout.low, layout.high  # type: ignore[attr-defined]
    observations = rng.uniform(low, high, (200, len(low))).astype(np.float32)
    decoded = layout.decode(observations)  # type: ignore[attr-defined]

    assert np.array_equal(layout.encode(decoded), observations)  # type: ignore[attr-defined]
    single = {name: values[3] for name, values in decoded.items()}
    assert np.array_equal(layout.encode(single), observations[3])  # type: ignore[attr-defined]


def test_values_out_of_bounds_are_clipped_and_nan_stays() -> None:
    layout = LAYOUTS["sonar"]
    fields = dict.fromkeys(layout.names, 1e6) | {"speed_mps": -1e6, "x_e_m": float("nan")}
    decoded = layout.decode(layout.encode(fields))

    assert decoded["range_left_m"] == 4.0
    assert decoded["speed_mps"] == -TOP_SPEED_MPS
    assert np.isnan(decoded["x_e_m"])


def test_missing_and_unknown_fields_are_refused() -> None:
    layout = LAYOUTS["sonar"]
    fields = dict.fromkeys(layout.names, 0.0)

    with refused("speed_kmh ... speed_mps"):
        layout.encode({**fields, "speed_kmh": 1.0})
    del fields["yaw_rate_radps"]
    with refused("yaw_rate_radps ... missing"):
        layout.encode(fields)


def test_person_fields_are_those_of_the_nearest_people() -> None:
    robot, tracks = records(ROBOT, 1), records(TRACK, 2)
    robot["v"] = 0.4
    tracks["visible"], tracks["pattern"] = 1, (CROSSING, NO_PATTERN)
    tracks["x"], tracks["y"], tracks["vx"] = (3.0, 1.5), (4.0, 0.0), (-0.6, 0.0)
    fields = person_fields(tracks, robot, PERSON_SLOTS)

    assert list(fields) == [name for name in LAYOUTS["tracks"].names if name.startswith("person")]
    assert fields["person0_distance_m"] == 1.5
    assert fields["person1_distance_m"] == pytest.approx(5.0)
    assert fields["person1_bearing_sin"] == pytest.approx(0.8)
    assert fields["person1_closing_mps"] == pytest.approx(1.0 * 0.6)
    assert (fields["person0_crossing"], fields["person1_crossing"]) == (0.0, 1.0)
    assert (fields["person2_present"], fields["person2_distance_m"]) == (0.0, 8.0)
