from __future__ import annotations

from pathlib import Path

import pytest

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_table import read_table


def written(folder: Path, text: str, name: str = "walk.txt") -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "frame,id,x,y\n0,3,1.0,2.0\n1,3,1.5,2.0\n",
        "x;y;id;frame\n1.0;2.0;3;0\n1.5;2.0;3;1\n",
        "3 0 1.0 2.0 1.8\n3 1 1.5 2.0 1.8\n",  # Juelich with the height
        "3\t0\t1.0\t2.0\n\n3\t1\t1.5\t2.0\n",
        "# id frame x/m y/m z/m\n3 0 1.0 2.0 1.8\n3 1 1.5 2.0 1.8\n",
        "# PersID\tFrame\tX\tY\n3 0 1.0 2.0\n3 1 1.5 2.0\n",
        "# frame id x [m] y [m]\n0 3 1.0 2.0\n1 3 1.5 2.0\n",
        "# the id of each frame with x and y, in words\n3 0 1.0 2.0\n3 1 1.5 2.0 # late\n",
        "0e0 3e0 1.0 0 2.0 5 0 0\n1e0 3e0 1.5 0 2.0 5 0 0\n",  # obsmat
        "frame,id,x,y\n1,3,1.5,2.0\n0,3,1.0,2.0\n",  # the order of rows does not matter
    ],
)
def test_every_format_is_recognised(tmp_path: Path, text: str) -> None:
    table = read_table(written(tmp_path, text))

    assert table.ids.tolist() == [3, 3]
    assert table.frames.tolist() == [0, 1]
    assert table.positions.tolist() == [[1.0, 2.0], [1.5, 2.0]]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "walk.txt: is empty"),
        ("# only a comment\n\n", "walk.txt: is empty"),
        ("frame,id,x,y\n", "walk.txt: is empty"),
        ("1 2\n3 4\n", "unknown format: 2 columns without names"),
        ("time,who,x,y\n0,1,2,3\n", "unknown format: 4 columns named 'time,who,x,y'"),
        ("frame,id,x,y,z\n0,1,2,3\n", "unknown format: 4 columns named 'frame,id,x,y,z'"),
        ("frame,id,x,y\n0,1,2,3\n1,1,2\n", "line 3: 3 columns instead of 4"),
        ("# note\n\n1 0 1 2\n1 1 1 a\n", "line 4: 'a' is not a number"),
        ("frame,id,x,y\n0,1,,3\n", "line 2: '' is not a number"),
        ("1 0 1 2\n1 1 nan 2\n", "line 2: a cell is not a finite number"),
        ("1 0 1 2\n1 0.5 1 2\n", "line 2: id and frame must be whole numbers"),
        ("1 0 1 2\n1 1 1 2\n1 0 1 2\n", "line 3: this person was already seen in this frame"),
    ],
)
def test_every_fault_is_one_line_that_says_where(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        read_table(written(tmp_path, text))

    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_and_binary_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"none\.csv: cannot be read \(No such file"):
        read_table(tmp_path / "none.csv")
    (tmp_path / "film.txt").write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InvalidInput, match=r"film\.txt: is not a text file"):
        read_table(tmp_path / "film.txt")
