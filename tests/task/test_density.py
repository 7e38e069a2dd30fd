from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hazbot_gym.task.density import densities_and_speeds, fundamental_diagram
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.tracks import Corridor, Recording
from tests.refusals import refused

DT_S = 0.1


def column(people: int, spacing_m: float, speed_mps: float) -> Recording:
    """Return people who walk through a corridor 2 m wide in a line, one behind the other."""
    steps = int((20.0 + people * spacing_m) / speed_mps / DT_S)
    x = speed_mps * DT_S * np.arange(steps)[None, :] - spacing_m * np.arange(people)[:, None] - 10.0
    return Recording(
        name="column",
        dt_s=DT_S,
        ids=np.arange(people),
        first_steps=np.zeros(people, np.int64),
        lengths=np.full(people, steps),
        positions=np.stack([x, np.zeros_like(x)], axis=-1).reshape(-1, 2),
        corridor=Corridor("x", (-5.0, 5.0), (-1.0, 1.0)),
    )


def test_a_column_has_the_density_of_its_spacing_and_its_speed() -> None:
    # 2 m spacing in an area 2 m long and 2 m wide: one person at a time, or two at the very edges.
    densities, speeds = densities_and_speeds(column(30, 2.0, 1.2)).T
    assert np.median(densities) == 0.25
    np.testing.assert_allclose(speeds, 1.2)


def test_bins_hold_the_moments_between_their_edges() -> None:
    bins = fundamental_diagram(column(60, 0.5, 0.8))
    dense = max(bins, key=lambda each: each.samples)
    assert (dense.low, dense.high) == (1.0, 1.25)
    assert dense.low <= dense.density < dense.high
    assert dense.speed_mps == pytest.approx(0.8)


def test_what_is_rarely_seen_is_not_spoken_of() -> None:
    assert fundamental_diagram(column(1, 2.0, 1.2)) == []


def test_the_open_has_no_density() -> None:
    recording = column(3, 2.0, 1.2)
    with refused("not of a corridor"):
        fundamental_diagram(Recording(**{**recording.__dict__, "corridor": None}))


def test_real_people_slow_down_where_it_is_dense(tracks_dir: Path) -> None:
    run = tracks_dir / "juelich_bi_corridor_300" / "bot-300-085-085.csv"
    speeds = [each.speed_mps for each in fundamental_diagram(read_tracks(run))]
    assert len(speeds) == 5
    assert speeds == sorted(speeds, reverse=True)
