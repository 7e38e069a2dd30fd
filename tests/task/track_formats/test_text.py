from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.track_formats import Given, Table, UnknownFormat, read_table
from tests.refusals import refused

BOXES = "0 100 200 140 260 {} {} 0 0 {}\n"


def written(folder: Path, text: str | bytes, name: str = "walk.txt") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read(folder: Path, text: str | bytes, **given: object) -> Table:
    return read_table(written(folder, text), Given(**given))


@pytest.mark.parametrize(
    "text",
    [
        "frame,id,x,y\n0,3,1.0,2.0\n1,3,1.5,2.0\n",
        "x;y;id;frame\n1.0;2.0;3;0\n1.5;2.0;3;1\n",
        "x;y;id;frame\n1,0;2,0;3;0\n1,5;2,0;3;1\n",  # decimal comma
        '"frame","id","x","y"\n"0","3","1,0","2"\n"1","3","1,5","2"\n',
        "3 0 1.0 2.0 1.8\n3 1 1.5 2.0 1.8\n",  # Juelich with the height
        "3\t0\t1.0\t2.0\n\n3\t1\t1.5\t2.0\n",
        "3 0 1,0 2,0 1,8\n3 1 1,5 2,0 1,8\n",
        "# id frame x/m y/m z/m\n3 0 1.0 2.0 1.8\n3 1 1.5 2.0 1.8\n",
        "# PersID\tFrame\tX\tY\n3 0 1.0 2.0\n3 1 1.5 2.0\n",
        "# frame id x [m] y [m]\n0 3 1.0 2.0\n1 3 1.5 2.0\n",
        "# the id of each frame with x and y, in words\n3 0 1.0 2.0\n3 1 1.5 2.0 # late\n",
        "0e0 3e0 1.0 0 2.0 5 0 0\n1e0 3e0 1.5 0 2.0 5 0 0\n",  # obsmat
        "frame,id,x,y\n1,3,1.5,2.0\n0,3,1.0,2.0\n",  # the order of rows does not matter
        "track_id,frame_id,timestamp_ms,kind,x,y\n3,0,100,a,1,2\n3,1,140,b,1.5,2\n",
        "recordingId,trackId,frame,heading,xCenter,yCenter\n9,3,0,7,1,2\n9,3,1,7,1.5,2\n",
        'ped_id\tframe\tpos_x\tpos_y\tkind\n3\t0\t1\t2\ta young man\n3\t1\t1.5\t2\t"a\tb"\n',
        'frame,id,name,x,y\n0,3,"Smith, J.",1,2\n1,3,"#2",1.5,2\n',
        "frame,id,x,y\n0,3,1,2,\n1,3,1.5,2,\n",  # separators at the end of rows
        "frame,id,x,y\n0,3,1,2\n  # a comment\n   \n,,,\n1,3,1.5,2\n",
        "frame,id,x,y\r0,3,1,2\r1,3,1.5,2\r",
        "\ufeffframe,id,x,y\r\n0,3,1,2\r\n1,3,1.5,2\r\n",
        "# K\xf6ln\nframe,id,x,y,place\n0,3,1,2,Stra\xdfe\n1,3,1.5,2,-\n".encode("latin-1"),
    ],
)
def test_every_layout_and_name_is_recognized(tmp_path: Path, text: str | bytes) -> None:
    table = read(tmp_path, text)

    assert table.ids.tolist() == [3, 3]
    assert table.frames.tolist() == [0, 1]
    assert table.positions.tolist() == [[1.0, 2.0], [1.5, 2.0]]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "walk.txt ... empty"),
        ("# only a comment\n\n", "walk.txt ... empty"),
        ("frame,id,x,y\n", "walk.txt ... empty"),
        ("frame,id,x,y\n0,1,2,3\n1,1,2\n", "line 3 ... 3 columns ... 4"),
        ("frame,id,x,y\n0,1,2,3\n1,1,2,3,4\n", "line 3 ... 5 columns ... 4"),
        ("frame,id,x,y,z\n0,1,2,3\n", "line 2 ... 4 columns ... 5"),
        ("# note\n\n1 0 1 2\n1 1 1 a\n", "line 4 ... 'a' ... number"),
        ("frame,id,x,y\n0,1,,3\n", "line 2 ... '' ... number"),
        ("frame,id,x,y\n0,1,2,3\n # b\n\n,,,\n1,1,True,3\n", "line 6 ... 'True' ... number"),
        ("frame;id;x;y\n0;1;2,5;3\n1;1;2.5;3\n", "line 2 ... '2,5' ... number"),
        ("frame,id,x,y\n0,p1,2,3\n1,7,2,3\n", "line 2 ... 'p1' ... number"),
        ("1 0 1 2\n1 1 nan 2\n", "line 2 ... finite"),
        ("frame,id,x,y\n0,1,2,3\n1,1,inf,3\n", "line 3 ... finite"),
        ("frame,id,x,y\n0,1,2,3\n0.5,1,2,3\n", "line 3 ... id and frame"),
        ("0.1 1 1 2\n0.2 1 1 2\n", "line 1 ... id and frame"),
        ("1 0 1 2\n1 1 1 2\n1 0 1 2\n", "line 3 ... already"),
        ("frame,id,x,y\n0,1,2,3\n1e300,1,2,3\n", "line 3 ... id and frame ... 90071"),
        ("frame,id,x,y\n0,1,2,3\n1,1,1e300,3\n", "line 3 ... position ... 1e9"),
        ("time,id,x,y\n0,1,2,3\n6e10,1,1,3\n", "line 3 ... 1e+09 s"),
        ("time,id,x,y\n0,1,2,3\ninf,1,1,3\n", "line 3 ... 1e+09 s"),
        ("time,id,x,y\n2020-01-01,1,2,3\n2020-13-01,1,2,3\n", "line 3 ... '2020-13-01'"),
        ("frame,id,track_id,x,y\n0,1,2,3,4\n", "id ... 'id' and 'track_id'"),
        ("frame,id,x [m],y [cm]\n0,1,2,3\n", "x and y ... cm, m"),
        ("# framerate: 25\n# 16 fps\n1 0 1 2\n1 1 1 2\n", "16 and 25"),
    ],
)
def test_every_fault_is_one_line_that_says_where(tmp_path: Path, text: str, complaint: str) -> None:
    with refused(complaint):
        read(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("1 2\n3 4\n", "2 columns"),
        ("1 0 1 2 3 4 bad\n", "7 columns"),  # said before the cell
        ("1,1,10,20,30,40,1,-1,-1,-1\n", "10 columns"),  # boxes of MOT
        ("time,who,x,y\n0,1,2,3\n", "'time,who,x,y'"),
        ("sample,human,x_m,y_m\n1,2,oops,3\n", "'sample,human,x_m,y_m'"),
        ("1," * 70_000, "line 1 ... 140000 bytes"),
        ("1 " * 2000, "2000 columns"),
    ],
)
def test_unknown_format_is_said_with_the_list_of_those_read(
    tmp_path: Path, text: str, complaint: str
) -> None:
    with refused(f"walk.txt ... unknown format ... {complaint} ... TrajNet++", error=UnknownFormat):
        read(tmp_path, text)


def test_missing_and_binary_files_are_refused(tmp_path: Path) -> None:
    with refused("none.csv ... No such file"):
        read_table(tmp_path / "none.csv")
    with refused("walk.txt ... text"):
        read(tmp_path, b"\xff\xfe\x00\x81")


@pytest.mark.parametrize(
    ("comment", "fps"),
    [
        ("framerate: 25.00", 25.0),
        ("Frame rate [1/s]: 12.5 fps", 12.5),
        ("frame_rate = .5", 0.5),
        ("fps=1e1", 10.0),
        ("framerate: 7,5", 7.5),
        ("recorded at 16 fps with two cameras", 16.0),
        ("recorded 2013", None),
        ("framerate: unknown, recorded 2013", None),
        ("frame rate as in 2013", None),
        ("framerate 25a", None),
    ],
)
def test_frame_rate_in_a_comment_is_the_number_that_follows(
    tmp_path: Path, comment: str, fps: float | None
) -> None:
    table = read(tmp_path, f"# {comment}\nframe,id,x,y\n0,1,2,3\n1,1,2,3\n")

    assert (table.fps, table.fps_from) == (fps, "comment" if fps else "")


@pytest.mark.parametrize(
    ("head", "unit", "came_from"),
    [
        ("frame,id,x_cm,y_cm", "cm", "names in the file"),
        ("frame,id,pos_x [mm],pos_y [mm]", "mm", "names in the file"),
        ("frame,id,x/m,y/m", "m", "names in the file"),
        ("# unit: cm\nframe,id,x,y", "cm", "comment"),
        ("# x in mm\nframe,id,x,y", "mm", "comment"),
        ("frame,id,x,y", None, ""),
    ],
)
def test_unit_is_that_of_the_names_or_a_comment(
    tmp_path: Path, head: str, unit: str | None, came_from: str
) -> None:
    table = read(tmp_path, head + "\n0,1,2,3\n1,1,2,3\n")

    assert (table.unit, table.unit_from) == (unit, came_from)


@pytest.mark.parametrize("name", ["time", "timestamp_ms", "t [s]", "timestamp"])
def test_time_stamps_become_frames(tmp_path: Path, name: str) -> None:
    per_s = 1000 if "ms" in name else 1
    rows = "".join(f"{round(k / 30 * per_s, 2)},{p},{k},0\n" for k in range(90) for p in (1, 2))
    table = read(tmp_path, f"{name},id,x,y\n{rows}")

    assert table.frames[:90].tolist() == list(range(90))
    assert (table.fps, table.fps_from) == (30.0, "time column")


def test_dates_and_words_for_people_are_read(tmp_path: Path) -> None:
    rows = "".join(f"2020-01-01T10:00:{k / 10:04.1f}Z,{p},{k},0\n" for k in range(9) for p in "ba")
    table = read(tmp_path, f"timestamp,track,x,y\n{rows}")

    assert table.fps == 10.0
    assert table.ids.tolist() == [1] * 9 + [2] * 9, "in order of appearance"
    assert table.frames.tolist() == [*range(9), *range(9)]


def test_time_beside_frames_gives_their_rate(tmp_path: Path) -> None:
    rows = "".join(f"{10 * k},{round(0.4 * k, 2)},1,{k},0\n" for k in range(9))

    assert read(tmp_path, f"frame,time,id,x,y\n{rows}").fps == 25.0


def test_given_columns_go_before_names_and_skip_others(tmp_path: Path) -> None:
    text = "a,b,c,d,e\n7,0,3,1,2\n7,1,3,1.5,2\n"
    columns = ("-", "frame", "id", "x_m", "y_m")
    table = read(tmp_path, text, columns=columns, columns_from="option")

    assert table.positions.tolist() == [[1.0, 2.0], [1.5, 2.0]]
    assert (table.form, table.form_from) == ("- frame id x y", "option")
    assert (table.unit, table.unit_from) == ("m", "option")


@pytest.mark.parametrize(
    ("columns", "complaint"),
    [
        ("frame id x", "columns ... 'frame id x' ... id, frame or time, x and y"),
        ("frame id x y", "columns ... 4 ... 5"),
        ("frame id x x y", "x ... 'x' and 'x'"),
        ("", "columns ... ''"),
    ],
)
def test_given_columns_that_do_not_fit_are_refused(
    tmp_path: Path, columns: str, complaint: str
) -> None:
    with refused(complaint):
        read(tmp_path, "7,0,3,1,2\n7,1,3,1.5,2\n", columns=tuple(columns.split()))


def test_drone_annotations_are_middles_of_pedestrians_in_pixels(tmp_path: Path) -> None:
    rows = [BOXES.format(0, 0, '"Pedestrian"'), BOXES.format(1, 0, '"Pedestrian"')]
    others = [BOXES.format(2, 1, '"Pedestrian"'), BOXES.format(3, 0, '"Biker"')]
    table = read(tmp_path, "".join(rows + others))

    assert table.frames.tolist() == [0, 1]
    assert table.positions.tolist() == [[120.0, 230.0]] * 2
    assert (table.form, table.unit) == ("Stanford Drone annotations", "px")
    assert table.notes == ("1 lost positions are left out", "only pedestrians are read, not: biker")
    with refused("pedestrian"):
        read(tmp_path, others[1])


def test_drone_annotations_with_names_are_the_same(tmp_path: Path) -> None:
    head = "trackId,xmin,ymin,xmax,ymax,frame,lost,occluded,generated,label\n"
    rows = "0,100,200,140,260,0,0,0,0,Pedestrian\n0,100,200,140,260,1,0,0,0,Pedestrian\n"

    assert read(tmp_path, head + rows).positions.tolist() == [[120.0, 230.0]] * 2


@pytest.mark.parametrize("name", ["class", "agent_type", "Label"])
def test_vehicles_among_named_columns_are_not_read_as_people(tmp_path: Path, name: str) -> None:
    head = f"frame,track_id,x,y,{name}\n"
    rows = "0,1,1,2,pedestrian\n1,1,2,2,pedestrian\n0,2,5,5,Car\n1,2,9,5,Car\n0,3,7,7,adult\n"

    table = read(tmp_path, head + rows)

    assert table.ids.tolist() == [1, 1, 3]
    assert table.notes == ("only pedestrians are read, not: car",)
    numbers = head + "0,1,1,2,0\n1,1,2,2,1\n"
    assert len(read(tmp_path, numbers).ids) == 2


@pytest.mark.parametrize(
    "text",
    [
        "# fps" + " " * 100_000 + "x\nframe,id,x,y\n0,1,2,3\n",
        "frame,id,x,y" + " " * 50_000 + "km\n0,1,2,3\n",
        "frame id x y" + " " * 50_000 + "(\n0 1 2 3\n",
        "frame,id,x,y\n0,1,2,3\n1,1," + "1" * 100_000 + "x,3\n",
        "1 0 1 2\n1 1 1 " + "1" * 100_000 + "x\n",
    ],
)
def test_long_lines_do_not_hang(tmp_path: Path, text: str) -> None:
    with contextlib.suppress(InvalidInput):
        assert read(tmp_path, text).frames.tolist() == [0]
