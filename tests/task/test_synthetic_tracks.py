from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_statistics import statistics
from hazbot_gym.task.tracks import resample


@pytest.mark.parametrize("seed", range(20))
def test_nobody_comes_near_another_or_a_wall_or_the_middle(seed: int) -> None:
    recording = synthetic_recording(seed)
    sideways = np.abs(recording.positions[:, 1])

    assert statistics(recording).nearest_min_m > 0.4
    assert sideways.max() < 1.5 - 0.2
    assert sideways.min() > 0.3 + 0.2, "a robot can pass along the middle"


def test_people_walk_through_in_both_directions_at_human_speed() -> None:
    recording = synthetic_recording()
    ways = np.array([track[-1, 0] - track[0, 0] for track in recording.tracks()])
    numbers = statistics(recording)

    assert 5 <= np.sum(ways > 0) <= 20
    assert np.abs(ways) == pytest.approx(np.full(25, 12.0), abs=0.25)
    assert 50.0 < recording.duration_s < 70.0
    assert numbers.person_speed_mps == pytest.approx(1.34, abs=0.15)
    for track in resample(recording, 0.05).tracks():
        assert np.hypot(*np.diff(track, axis=0).T).max() < 2.2 * 0.05


def test_same_seed_gives_the_same_people_and_another_seed_others() -> None:
    first, again, other = (synthetic_recording(seed).positions for seed in (1, 1, 2))

    assert np.array_equal(first, again)
    assert first.shape != other.shape


def test_faster_walker_falls_in_behind_a_slower_one() -> None:
    recordings = [synthetic_recording(seed) for seed in range(10)]
    held_up = [
        np.ptp(np.abs(np.diff(track[:, 0]))) / recording.dt_s
        for recording in recordings
        for track in recording.tracks()
    ]

    assert max(held_up) > 0.2, "somebody slows down"
    assert np.median(held_up) < 0.01, "most do not"
