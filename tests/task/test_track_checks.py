from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hazbot_gym.task.track_checks import GUESS, doubts, median_speed, walking_speed
from hazbot_gym.task.tracks import Reading, Recording


def recording(speed_mps: float = 1.2, pieces: int = 1, steps: int = 50, size: float = 0.1):
    """Return one person in pieces of a track."""
    return Recording(
        name="few",
        dt_s=0.1,
        ids=np.ones(pieces, np.int64),
        first_steps=np.arange(pieces) * 2 * steps,
        lengths=np.full(pieces, steps),
        positions=np.tile(np.column_stack([np.arange(steps) * size, np.zeros(steps)]), (pieces, 1)),
        reading=Reading("a", "b", "m", "c", 10.0, "d", speed_mps),
    )


@pytest.mark.parametrize(
    ("strange", "doubt"),
    [
        (recording(0.29), "people walk at 0.29 m/s in the median"),
        (recording(2.21), "people walk at 2.21 m/s in the median"),
        (recording(size=0.02), "everything is within 0.98 m"),
        (recording(pieces=3), "1 ids are seen as 3 people"),
        (recording(steps=2, size=2.0), "an id is seen 2.0 times on average"),
    ],
)
def test_each_sign_is_said(strange: Recording, doubt: str) -> None:
    assert [line for line in doubts(strange) if line.startswith(doubt)]


def test_probable_recording_raises_no_doubt() -> None:
    usual = recording()

    assert doubts(usual) == []
    assert doubts(replace(usual, reading=None)) == []


@pytest.mark.parametrize(("unit", "is_said"), [("cm", True), ("m", False)])
def test_a_unit_other_than_the_meter_is_never_guessed_in_silence(unit: str, is_said: bool) -> None:
    usual = recording()
    assert usual.reading is not None
    guessed = replace(usual, reading=usual.reading._replace(unit=unit, unit_from=GUESS))

    assert [line.split(";")[0] for line in doubts(guessed)] == is_said * ["its unit is not given"]


def test_notes_of_the_reader_are_passed_on() -> None:
    usual = recording()
    assert usual.reading is not None
    assert doubts(replace(usual, reading=usual.reading._replace(notes=("a",)))) == ["a"]


def test_speed_is_that_over_a_second() -> None:
    ids, frames = np.repeat([1, 2], 40), np.tile(np.arange(40) * 10, 2)
    sway = 0.5 * (np.arange(80) % 2)  # from step to step
    positions = np.column_stack([0.48 * np.tile(np.arange(40), 2), sway])

    assert np.median(walking_speed(ids, frames, positions, 25.0)) == pytest.approx(1.2)
    assert len(walking_speed(np.arange(5), np.zeros(5, np.int64), np.zeros((5, 2)), 25.0)) == 0


def test_people_who_stand_do_not_count_unless_all_do() -> None:
    assert median_speed(np.array([0.0] * 9 + [1.0])) == 1.0
    assert median_speed(np.array([0.0] * 99 + [1.0])) == 0.0
