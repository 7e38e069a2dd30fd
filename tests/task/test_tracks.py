from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_folders import find_recordings
from hazbot_gym.task.tracks import Recording, resample, steps_on_clock


def two_people() -> Recording:
    """Return one who walks along x from 0 to 0.4 s, and one who stands from 0.2 to 0.5 s."""
    walks = [[0.1 * k, 0.0] for k in range(5)]
    stands = [[2.0, 3.0]] * 4
    return Recording(
        name="two",
        dt_s=0.1,
        ids=np.array([7, 9]),
        first_steps=np.array([0, 2]),
        lengths=np.array([5, 4]),
        positions=np.array(walks + stands),
    )


def test_tracks_are_each_persons_own_rows() -> None:
    walks, stands = two_people().tracks()

    assert walks[:, 0] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert stands.tolist() == [[2.0, 3.0]] * 4
    assert two_people().people == 2
    assert two_people().duration_s == pytest.approx(0.5)


def test_resampling_at_half_the_step_puts_points_halfway() -> None:
    fine = resample(two_people(), 0.05)
    walks, stands = fine.tracks()

    assert fine.first_steps.tolist() == [0, 4]
    assert walks[:, 0] == pytest.approx(0.05 * np.arange(9))
    assert stands.tolist() == [[2.0, 3.0]] * 7
    assert steps_on_clock(two_people(), 0.05) == 11


def test_resampling_at_the_own_step_gives_the_tracks_back() -> None:
    same = resample(two_people(), 0.1)

    assert same.positions == pytest.approx(two_people().positions)
    assert same.first_steps.tolist() == [0, 2]


def test_people_between_two_times_of_a_slow_clock_are_left_out() -> None:
    slow = resample(two_people(), 1.0)

    assert slow.ids.tolist() == [7]
    assert slow.positions.tolist() == [[0.0, 0.0]]


def test_memory_goes_with_the_sightings_and_not_with_the_duration() -> None:
    """6,000 people an hour took 7 GB as times x people, and 83 MB person by person."""
    people, seen = 2000, 10
    recording = Recording(
        name="hour",
        dt_s=0.5,
        ids=np.arange(people),
        first_steps=np.arange(people) * 50,
        lengths=np.full(people, seen),
        positions=np.zeros((people * seen, 2)),
    )
    tracemalloc.start()
    fine = resample(recording, 0.05)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert len(fine.positions) == people * ((seen - 1) * 10 + 1)
    assert peak < 4 * fine.positions.nbytes


def test_real_people_on_a_finer_clock_walk_no_faster(tracks_dir: Path) -> None:
    path = next(path for path in find_recordings(tracks_dir) if path.stem == "boa-300-050-070")
    for track in resample(read_tracks(path), 0.05).tracks():
        assert np.hypot(*np.diff(track, axis=0).T).max(initial=0.0) < 5.0 * 0.05
