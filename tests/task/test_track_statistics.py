from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.core.state import Floats
from hazbot_gym.task.synthetic_tracks import synthetic_recording
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_statistics import entries, statistics
from hazbot_gym.task.tracks import Recording

# Published with the tracks: people, duration, median speed of persons, share of samples that stand,
# people in view: median and most.
REAL = {
    "boa-300-050-070": (135, 68.5, 1.34, 0.00, 24, 36),
    "bot-300-085-085": (216, 73.4, 1.06, 0.00, 47, 61),
    "crossing_90_a_01": (247, 168.1, 1.41, 0.01, 8, 16),
    "zara01": (148, 360.4, 1.24, 0.04, 5, 20),
}


def recording_of(*tracks: tuple[int, Floats]) -> Recording:
    """Return a recording at 10 Hz of (first step, positions)."""
    return Recording(
        name="made up",
        dt_s=0.1,
        ids=np.arange(len(tracks)),
        first_steps=np.array([first for first, _ in tracks]),
        lengths=np.array([len(track) for _, track in tracks]),
        positions=np.concatenate([track for _, track in tracks]),
    )


def walk(y: float, speed: float, steps: int) -> Floats:
    return np.stack([0.1 * speed * np.arange(steps), np.full(steps, y)], axis=1)


def test_statistics_worked_out_by_hand() -> None:
    slow, fast, stands = walk(0.0, 0.8, 60), walk(2.0, 1.2, 40), walk(5.0, 0.0, 20)
    numbers = statistics(recording_of((0, slow), (60, fast), (70, stands)))

    assert (numbers.people, numbers.duration_s) == (3, pytest.approx(9.9))
    assert (numbers.people_in_view_median, numbers.people_in_view_max) == (1.0, 2)
    assert numbers.person_speed_mps == pytest.approx(0.8)
    assert numbers.person_speed_sd_mps == pytest.approx(np.std([0.0, 0.8, 1.2]))
    assert numbers.speed_percentiles_mps[2] == pytest.approx(0.8)
    assert numbers.standing_share == pytest.approx(3 / (3 + 7 + 12))  # samples every 0.4 s
    assert numbers.nearest_min_m == pytest.approx(math.hypot(1.2, 3.0))
    assert numbers.impossible_steps == 0


def test_jump_of_a_track_is_counted_as_an_impossible_step() -> None:
    jumps = walk(0.0, 1.0, 40)
    jumps[20:] += 0.5

    assert statistics(recording_of((0, jumps))).impossible_steps == 1


def test_nobody_near_and_nobody_long_enough_give_nan() -> None:
    numbers = statistics(recording_of((0, walk(0.0, 1.0, 5))))

    assert math.isnan(numbers.person_speed_mps)
    assert math.isnan(numbers.nearest_mean_m)


def test_entries_are_the_walkers_in_order() -> None:
    pauses = np.concatenate([walk(0.0, 1.0, 30), np.tile([[2.9, 0.0]], (60, 1))])
    recording = recording_of(
        (50, pauses),
        (0, walk(1.0, 1.2, 40)),
        (5, walk(2.0, 0.0, 40)),  # stands
        (5, walk(3.0, 1.5, 10)),  # seen for 0.9 s
    )

    found = entries(recording)

    assert found.times_s == pytest.approx([0.0, 5.0])
    assert found.entry_points == pytest.approx(np.array([[0.0, 1.0], [0.0, 0.0]]))
    assert found.exit_points == pytest.approx(np.array([[4.68, 1.0], [2.9, 0.0]]))
    assert found.speeds_mps == pytest.approx([1.2, 1.0])  # the pause does not count


def test_entries_of_a_recording_without_walkers_are_empty() -> None:
    found = entries(recording_of((0, walk(0.0, 0.0, 30))))

    assert found.times_s.shape == (0,)
    assert found.entry_points.shape == (0, 2)


def test_everybody_in_the_synthetic_recording_enters() -> None:
    recording = synthetic_recording()
    found = entries(recording)

    assert len(found.times_s) == recording.people
    assert (np.diff(found.times_s) >= 0.0).all()


@pytest.mark.parametrize("name", REAL)
def test_real_recordings_have_the_published_numbers(tracks_dir: Path, name: str) -> None:
    people, duration_s, speed, standing, in_view, most = REAL[name]
    numbers = statistics(read_tracks(next(tracks_dir.rglob(f"{name}.csv"))))

    assert numbers.people == people
    assert numbers.duration_s == pytest.approx(duration_s, abs=0.06)
    assert numbers.person_speed_mps == pytest.approx(speed, abs=0.03)
    assert numbers.standing_share == pytest.approx(standing, abs=0.006)
    assert (numbers.people_in_view_median, numbers.people_in_view_max) == (in_view, most)
    assert numbers.impossible_steps == 0
