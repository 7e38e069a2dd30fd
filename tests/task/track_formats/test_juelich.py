from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.errors import MissingExtra
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_formats import UnknownFormat, read_table
from tests.refusals import refused

FIELDS = [("id", "<i4"), ("frame", "<i4"), ("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
ROOM = "POLYGON ((0 -2, 20 -2, 20 2, 0 2, 0 -2))"


def written(folder: Path, dtype: Any = FIELDS, area: str | None = None, **attributes: Any) -> Path:
    h5py = pytest.importorskip("h5py")
    rows = np.zeros(200, dtype=dtype)
    for name, values in (
        ("id", np.repeat([1, 2], 100)),
        ("frame", np.tile(np.arange(100), 2)),
        ("x", np.tile(np.arange(100) * 0.0625, 2)),
    ):
        if name in rows.dtype.names:
            rows[name] = values
    path = folder / "walk.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("trajectory", data=rows).attrs.update(attributes)
        if area is not None:
            file.attrs["wkt_geometry"] = area
    return path


def test_people_rate_and_walls_are_read(tmp_path: Path) -> None:
    pytest.importorskip("shapely")
    recording = read_tracks(written(tmp_path, area=ROOM, fps=16.0))

    assert recording.people == 2
    assert recording.dt_s == 0.0625
    assert recording.positions[-1].tolist() == [6.1875, 0.0]
    assert recording.walls.shape == (4, 4)
    assert recording.reading is not None
    assert recording.reading[:6] == (
        *("Juelich hdf5", "format", "m", "format", 16.0, "attribute fps"),
    )


def test_without_h5py_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "walk.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n")
    monkeypatch.setitem(sys.modules, "h5py", None)

    with refused("h5py ... pip install 'hazbot-gym[tracks]'", error=MissingExtra):
        read_table(path)


def test_without_shapely_walls_are_not_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path, area=ROOM, fps=16.0)
    monkeypatch.setitem(sys.modules, "shapely", None)

    with refused("shapely", error=MissingExtra):
        read_table(path)


def test_every_fault_is_one_line(tmp_path: Path) -> None:
    pytest.importorskip("shapely")
    with refused("hdf5 ... trajectory", error=UnknownFormat):
        read_table(written(tmp_path, dtype=FIELDS[:3]))
    with refused("trajectory ... number"):
        read_table(written(tmp_path, fps="fast"))
    with refused("trajectory ... number"):
        read_table(written(tmp_path, fps=[1.0, 2.0]))
    for area in ("POLYGON ((0 0, 1", "POINT (1 2", "", "\\0", "POLYGON ((0 0, 1 0, 1 nan, 0 0))"):
        with refused("walk.h5 ... geometry"):
            read_table(written(tmp_path, fps=16.0, area=area))
    path = written(tmp_path, fps=16.0)
    path.write_bytes(path.read_bytes()[:2000])
    with refused("walk.h5 ... hdf5"):
        read_table(path)


def test_rate_that_the_file_does_not_tell_must_be_given(tmp_path: Path) -> None:
    path = written(tmp_path)

    with refused("walk.h5 ... fps"):
        read_tracks(path)
    assert read_tracks(path, fps=16.0).dt_s == 0.0625


def test_dataset_that_would_fill_the_memory_is_refused(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "walk.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("trajectory", shape=(10**11,), dtype=FIELDS, chunks=(1000,))

    with refused("one dimension ... 256 MiB"):
        read_table(path)
