from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.task.replay_place import replay_frame
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.tracks import Corridor
from tests.refusals import refused


def test_robot_drives_along_the_middle_of_a_corridor() -> None:
    frame = replay_frame(synthetic_recording())

    assert frame.start == pytest.approx([0.0, 0.0])
    assert frame.end == pytest.approx([12.0, 0.0])
    assert frame.walls.shape == (2, 4)


def test_corridor_along_y_is_driven_along_y() -> None:
    corridor = Corridor("y", (0.0, 3.0), (-4.0, 4.0))
    recording = replace(synthetic_recording(), corridor=corridor, walls=np.zeros((0, 4)))

    frame = replay_frame(recording)

    assert frame.start == pytest.approx([1.5, -4.0])
    assert frame.end == pytest.approx([1.5, 4.0])


def test_left_is_left_of_the_driving_direction() -> None:
    there = replay_frame(synthetic_recording(), lateral_m=0.5)
    back = replay_frame(synthetic_recording(), is_reversed=True, lateral_m=0.5)

    assert (there.start[1], there.end[1]) == pytest.approx((0.5, 0.5))
    assert back.start == pytest.approx([12.0, -0.5])
    assert back.end == pytest.approx([0.0, -0.5])


@pytest.mark.parametrize("lateral_m", [-1.25, 1.25, 1.6, -5.0])
def test_way_without_room_for_the_robot_is_refused(lateral_m: float) -> None:
    with refused("does not fit between"):
        replay_frame(synthetic_recording(), lateral_m=lateral_m)


def test_wall_across_the_way_is_refused() -> None:
    recording = synthetic_recording()
    across = np.array([[6.0, 0.2, 6.0, 1.5]])  # leaves the middle free, but not for the robot

    with refused("does not fit between"):
        replay_frame(replace(recording, walls=np.concatenate([recording.walls, across])))


def test_in_the_open_the_way_spans_ninety_percent_of_the_sightings() -> None:
    rng = np.random.default_rng(0)
    along, across = rng.uniform(-10.0, 10.0, 4000), rng.normal(0.0, 0.5, 4000)
    c, s = np.cos(2.0), np.sin(2.0)
    positions = np.stack([3.0 + c * along - s * across, s * along + c * across], axis=1)
    recording = replace(
        synthetic_recording(), positions=positions, corridor=None, walls=np.zeros((0, 4))
    )

    frame = replay_frame(recording)

    # The axis points towards +y, its larger component; 5 % of the length is left out at either end.
    assert frame.start == pytest.approx([3.0 - 9.0 * c, -9.0 * s], abs=0.3)
    assert frame.end == pytest.approx([3.0 + 9.0 * c, 9.0 * s], abs=0.3)


@pytest.mark.parametrize(
    "name", ["boa-300-050-070", "uo-180-180-120", "crossing_90_a_01", "zara01"]
)
def test_real_recordings_have_a_way_of_some_metres(tracks_dir: Path, name: str) -> None:
    recording = read_tracks(next(tracks_dir.rglob(f"{name}.csv")))
    frame = replay_frame(recording)

    assert 7.0 < np.hypot(*(frame.end - frame.start)) < 16.0
    assert len(frame.walls) == len(recording.walls)


def test_a_recording_without_room_is_named_with_the_way_that_was_tried() -> None:
    across = np.array([[6.0, -1.5, 6.0, 1.5]])
    blocked = replace(synthetic_recording(), walls=across)
    with refused("synthetic ... (0.0, 0.0) ... (12.0, 0.0)"):
        replay_frame(blocked)
