from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.errors import InvalidInput, MissingExtra
from hazbot_gym.task.track_files import read_tracks
from hazbot_gym.task.track_formats import UnknownFormat, read_table
from tests.refusals import refused

ROOM = "POLYGON ((0 -2, 20 -2, 20 2, 0 2, 0 -2), (5 0, 6 0, 6 1, 5 0))"
ROWS = [(k, p, 0.1 * k, float(p)) for k in range(100) for p in (-1, 1)]


def written(folder: Path, rows: list[Any] = ROWS, **metadata: Any) -> Path:
    path = folder / "walk.sqlite"
    database = sqlite3.connect(path)
    database.execute(
        "CREATE TABLE trajectory_data (frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL)"
    )
    database.executemany("INSERT INTO trajectory_data VALUES (?, ?, ?, ?)", rows)
    database.execute("CREATE TABLE metadata (key TEXT NOT NULL, value TEXT NOT NULL)")
    values = {"version": 3, "fps": 12.5, **metadata}
    database.executemany("INSERT INTO metadata VALUES (?, ?)", values.items())
    database.commit()
    database.close()
    return path


def changed(path: Path, *statements: str) -> Path:
    database = sqlite3.connect(path)
    for statement in statements:
        database.execute(statement)
    database.commit()
    database.close()
    return path


def test_people_rate_and_walls_are_read(tmp_path: Path) -> None:
    pytest.importorskip("shapely")
    path = changed(
        written(tmp_path),
        "CREATE TABLE geometry (hash INTEGER, wkt TEXT)",
        f"INSERT INTO geometry VALUES (1, '{ROOM}')",
    )
    recording = read_tracks(path)

    assert recording.people == 2
    assert recording.dt_s == 0.08
    assert recording.positions[-1].tolist() == [9.9, 1.0]
    assert recording.walls.shape == (7, 4)
    assert [0.0, -2.0, 20.0, -2.0] in recording.walls.tolist()
    assert recording.reading is not None
    assert recording.reading[:6] == ("JuPedSim", "format", "m", "format", 12.5, "metadata")
    assert recording.reading.notes == ()


def test_version_that_is_not_known_is_a_note(tmp_path: Path) -> None:
    assert read_table(written(tmp_path, version=9)).notes == (
        "version '9' of the format; known are 1, 2, 3",
    )


@pytest.mark.parametrize(
    ("statement", "complaint"),
    [
        ("UPDATE metadata SET value = 'a' WHERE key = 'fps'", "metadata: fps must be a number"),
        ("UPDATE trajectory_data SET pos_x = 'a' WHERE frame = 3", "a value is not a number"),
        ("UPDATE trajectory_data SET pos_x = NULL WHERE frame = 3", "is not a finite number"),
        ("UPDATE trajectory_data SET pos_x = 1e400 WHERE frame = 3", "is not a finite number"),
        ("UPDATE trajectory_data SET frame = 0", "already seen in this frame"),
        ("DELETE FROM trajectory_data", "is empty"),
        ("ALTER TABLE metadata RENAME COLUMN key TO name", "is not a usable database"),
        ("CREATE TABLE geometry (wkt TEXT)", "walk.sqlite"),
    ],
)
def test_every_fault_is_one_line(tmp_path: Path, statement: str, complaint: str) -> None:
    path = changed(written(tmp_path), statement)
    if "geometry" in statement:
        changed(path, "INSERT INTO geometry VALUES ('POLYGON ((0 0')")
    with pytest.raises((InvalidInput, MissingExtra)) as caught:
        read_table(path)

    assert complaint in str(caught.value) or isinstance(caught.value, MissingExtra)
    assert "\n" not in str(caught.value)


def test_other_databases_are_another_format(tmp_path: Path) -> None:
    endless = (
        "CREATE VIEW trajectory_data AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 "
        "FROM n) SELECT id, id AS frame, 0.0 AS pos_x, 0.0 AS pos_y FROM n"
    )
    path = changed(written(tmp_path), "DROP TABLE trajectory_data", endless)

    with refused("trajectory_data", error=UnknownFormat):
        read_table(path)


def test_damaged_database_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_bytes(path.read_bytes()[:3000])

    with refused("walk.sqlite ... database"):
        read_table(path)


def test_walls_beyond_all_bounds_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("shapely")
    teeth = ", ".join(f"{k} {k % 2 + 1}" for k in range(5001))
    path = changed(
        written(tmp_path),
        "CREATE TABLE geometry (wkt TEXT)",
        f"INSERT INTO geometry VALUES ('POLYGON ((0 0, {teeth}, 5000 0, 0 0))')",
    )

    with refused("geometry ... 5003 ... 5000"):
        read_table(path)


def test_damaged_text_of_a_table_is_one_line(tmp_path: Path) -> None:
    path = written(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"CREATE TABLE meta", b"CREATE \xf2ABLE meta"))
    with refused("database"):
        read_tracks(path)
