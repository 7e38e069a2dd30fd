from __future__ import annotations

import numpy as np

from hazbot_gym.core.recorded_table import NO_STRETCH, RecordedTable, Stretch, rows_from, stretch_of

# Two recordings: of three people in two slots, and of one person who comes at step 4.
TABLE = RecordedTable(
    dt_s=0.1,
    recording_of_place=np.array([0, 0, 1, 1]),
    ways=np.array([[0, 1], [2, 3]]),
    counts=np.array([10, 8]),
    slots=np.array([[0, 2, 3], [3, 4, 4]]),
    firsts=np.array([1, 7, 0, 4]),
    offsets=np.array([0, 3, 5, 15, 18]),
    positions=np.arange(36.0).reshape(18, 2),
)


def there(stretch: Stretch, slot: int) -> list[int | None]:
    """Return the row of who is in a slot at every step, None if nobody is."""
    rows = [rows_from(stretch, slot, step) for step in range(stretch.steps)]
    return [row if row < end else None for row, end in rows]


def test_a_slot_serves_one_person_after_another() -> None:
    stretch = stretch_of(TABLE, 0, 0)
    assert there(stretch, 0) == [None, 0, 1, 2, None, None, None, 3, 4, None]
    assert there(stretch, 1) == list(range(5, 15))


def test_both_ways_lead_through_the_same_recording() -> None:
    assert there(stretch_of(TABLE, 2, 0), 0) == [None, None, None, None, 15, 16, 17, None]
    assert there(stretch_of(TABLE, 3, 0), 0) == there(stretch_of(TABLE, 2, 0), 0)


def test_a_slot_that_a_smaller_recording_does_not_need_stays_empty() -> None:
    assert there(stretch_of(TABLE, 2, 0), 1) == [None] * 8


def test_an_episode_starts_in_the_midst_of_a_recording() -> None:
    stretch = stretch_of(TABLE, 1, 2)
    assert there(stretch, 0) == [1, 2, None, None, None, 3, 4, None]


def test_without_a_recording_there_is_no_step() -> None:
    assert NO_STRETCH.steps == 0
    assert len(NO_STRETCH.slots) == 1
