from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.task.track_formats.clock import frames_of, rate_of
from tests.refusals import refused


@pytest.mark.parametrize("fps", [2.5, 10.0, 16.0, 25.0, 29.97, 30.0, 60.0, 120.0, 7.3])
@pytest.mark.parametrize("digits", [3, 6])
def test_rate_is_found_whatever_stamps_are_rounded_to(fps: float, digits: int) -> None:
    frames = np.concatenate([np.arange(500), np.arange(700, 900), np.arange(3, 2000)])
    ids = np.repeat([1, 2, 3], [500, 200, 1997]).astype(np.float64)
    found, rate = frames_of("a", ids, np.round(1e5 + frames / fps, digits))

    assert rate == pytest.approx(fps, rel=2e-4)
    assert np.array_equal(found, frames)


def test_trembling_stamps_are_put_on_their_clock() -> None:
    rng = np.random.default_rng(1)
    frames = np.arange(0, 3000)[rng.random(3000) < 0.8]
    stamps = frames / 10 + rng.uniform(-0.01, 0.01, len(frames))
    found, rate = frames_of("a", np.ones(len(frames)), stamps)

    assert rate == pytest.approx(10.0, abs=0.01)
    assert np.array_equal(found - found[0], frames - frames[0])


def test_known_rate_is_used() -> None:
    found, rate = frames_of("a", np.ones(4), np.array([0.0, 0.4, 0.8, 2.0]), fps=25.0)

    assert (found.tolist(), rate) == ([0, 10, 20, 50], 25.0)


@pytest.mark.parametrize(
    ("times_s", "fps", "complaint"),
    [
        ([0.0, 0.1, 0.2, 0.3, 0.4, 0.55, 0.65], None, "multiples"),
        ([0.0, 0.01, 0.04, 0.1, 0.17, 0.3, 0.47], 10.0, "0.1 s ... 40%"),
        ([0.0, 0.1, 0.2], 7.0, "multiples"),
        ([0.0, 1e-9, 2e-9, 50.0], None, "1e-09 s ... 50 s"),
        ([0.0, 0.0, 0.0], None, "one time"),
    ],
)
def test_stamps_without_a_common_step_are_refused(
    times_s: list[float], fps: float | None, complaint: str
) -> None:
    with refused(complaint):
        frames_of("a", np.ones(len(times_s)), np.array(times_s), fps)


def test_rate_of_frames_is_none_where_times_do_not_agree() -> None:
    frames = np.arange(100.0) * 10

    assert rate_of(frames, np.round(frames / 25, 2)) == 25.0
    assert rate_of(frames, frames**2) is None
    assert rate_of(frames, np.zeros(100)) is None
