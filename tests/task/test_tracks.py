from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_folders import find_recordings
from hazbot_gym.task.tracks import Recording, resample, window


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
    positions = resample(two_people(), 0.05)

    assert positions.shape == (11, 2, 2)
    assert positions[:9, 0, 0] == pytest.approx(0.05 * np.arange(9))
    assert np.isnan(positions[9:, 0]).all()
    assert np.isnan(positions[:4, 1]).all()
    assert (positions[4:, 1] == [2.0, 3.0]).all()


def test_resampling_at_the_own_step_gives_the_tracks_back() -> None:
    positions = resample(two_people(), 0.1)

    assert positions[:5, 0] == pytest.approx(two_people().tracks()[0])
    assert positions[2:, 1] == pytest.approx(two_people().tracks()[1])


def test_window_holds_only_people_who_are_seen_in_it() -> None:
    early = window(two_people(), 0.05, 0.15, 0.05)

    assert early.shape == (3, 1, 2)
    assert early[:, 0, 0] == pytest.approx([0.05, 0.10, 0.15])
    assert window(two_people(), 0.2, 0.1, 0.05).shape == (2, 2, 2)
    assert window(two_people(), 5.0, 1.0, 0.05).shape == (20, 0, 2)


def test_window_of_everything_is_the_whole_recording(tracks_dir: Path) -> None:
    path = next(path for path in find_recordings(tracks_dir) if path.stem == "boa-300-050-070")
    recording = read_tracks(path)
    whole = resample(recording, 0.05)

    part = window(recording, 20.0, 10.0, 0.05)

    seen = ~np.isnan(whole[400:600, :, 0]).all(axis=0)
    assert np.allclose(part, whole[400:600][:, seen], atol=1e-9, equal_nan=True)
    assert np.nanmax(np.hypot(*np.diff(whole, axis=0).T)) < 5.0 * 0.05
