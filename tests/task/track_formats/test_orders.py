from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.core.state import Floats
from hazbot_gym.task.track_formats.orders import recognized
from tests.refusals import refused


def crowd(people: int = 12, frames: int = 30, every: int = 1, seed: int = 0) -> Floats:
    """Return id, frame, x, y of people who come one after another, and walk either way."""
    rng = np.random.default_rng(seed)
    rows = []
    for person in range(people):
        start, way = rng.integers(0, 40), rng.choice([-1, 1])
        lane = rng.uniform(0, 3)
        for k in range(frames):
            rows.append((person + 1, (start + k) * every, way * (0.5 * k - 7), lane))
    return np.array(rows, dtype=np.float64) + rng.normal(0, 0.02, (len(rows), 4)) * [0, 0, 1, 1]


def swapped(cells: Floats) -> Floats:
    return cells[:, [1, 0, *range(2, cells.shape[1])]]


def with_velocities(cells: Floats) -> Floats:
    way = np.sign(np.gradient(cells[:, 2]))
    return np.column_stack([cells, 1.25 * way, 0.0 * way])


@pytest.mark.parametrize("every", [1, 10])
@pytest.mark.parametrize(("people", "frames"), [(12, 30), (60, 20), (3, 200), (1, 50)])
@pytest.mark.parametrize("is_sorted_by_time", [True, False])
def test_both_orders_of_id_and_frame_are_told_apart(
    people: int, frames: int, every: int, is_sorted_by_time: bool
) -> None:
    moving = with_velocities(crowd(people, frames, every))
    if is_sorted_by_time:
        moving = moving[np.argsort(moving[:, 1], kind="stable")]
    cells = moving[:, :4]

    assert recognized("a", cells) == "id frame x y"
    assert recognized("a", swapped(cells)) == "frame id x y"
    tall = np.column_stack([cells, np.full(len(cells), 1.8)])
    assert recognized("a", tall) == "id frame x y z"
    assert recognized("a", swapped(tall)) == "frame id x y z"
    assert recognized("a", swapped(moving)) == "frame id x y vx vy"


def test_few_people_in_rank_and_file_are_told_by_their_frames() -> None:
    cells = [(10 * t, p, 0.5 * t, p) for t in range(40) for p in (1, 2, 3)]

    assert recognized("a", np.array(cells, dtype=np.float64)) == "frame id x y"


@pytest.mark.parametrize("height", [0.0, 1.7])
def test_height_of_eight_columns_is_the_one_that_is_constant(height: float) -> None:
    cells = swapped(with_velocities(crowd()))
    zero, tall = np.zeros(len(cells)), np.full(len(cells), height)
    frame, person, x, y, vx, vy = cells.T
    obsmat = np.column_stack([frame, person, x, tall, y, vx, zero, vy])
    xyz = np.column_stack([frame, person, x, y, tall, vx, vy, zero])

    assert recognized("a", obsmat) == "frame id x z y vx vz vy"
    assert recognized("a", xyz) == "frame id x y z vx vy vz"


def test_what_cannot_be_told_is_refused() -> None:
    cells = crowd()
    number = np.arange(len(cells), dtype=np.float64)
    clock = 0.4 * cells[:, 1]
    boxes = np.column_stack([cells, np.full(len(cells), 40.0), np.full(len(cells), 90.0)])
    grid = np.array([(a, b, a, b) for a in range(9) for b in range(9)], dtype=np.float64)
    unknown = {
        "id and frame": grid,
        "the third counts with the frames": np.column_stack([cells[:, :2], clock, cells[:, 2:]])[
            :, :5
        ],
        "velocities": boxes,
        "8 columns": np.column_stack([cells, cells[:, 3:] * 2, *cells.T[1:]]),
        "could be either way": np.column_stack([number, number, cells[:, 2:]]),
    }

    for complaint, table in unknown.items():
        with refused(complaint):
            recognized("a", table)


def test_real_files_are_recognized_without_their_names(tracks_dir: Path) -> None:
    tables = [*tracks_dir.glob("juelich*/*.csv"), *tracks_dir.glob("ucy*/*.csv")]

    assert len(tables) >= 8
    for table in tables:
        cells = np.loadtxt(table, delimiter=",", skiprows=1)
        assert recognized(table.name, cells) == "frame id x y"
        by_person = swapped(cells)[np.lexsort((cells[:, 0], cells[:, 1]))]
        assert recognized(table.name, by_person) == "id frame x y"
