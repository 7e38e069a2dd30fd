from __future__ import annotations

import io
from pathlib import Path

from hazbot_gym.calibration.tracks_report import describe
from hazbot_gym.task.track_files import Options
from hazbot_gym.utils.terminal import output_console
from tests.refusals import refused, says

GOOD = "# framerate: 10\n" + "".join(
    f"1 {k} {0.1 * k} 0\n2 {k} {9 - 0.1 * k:.1f} 0.5\n" for k in range(91)
)


def printed(path: Path) -> str:
    out = io.StringIO()
    describe(path, output_console(out, width=140))
    return out.getvalue()


def test_numbers_and_patterns_of_every_recording_are_printed(tmp_path: Path) -> None:
    (tmp_path / "first.txt").write_text(GOOD)
    (tmp_path / "second [b].txt").write_text(GOOD.replace(" 0.5", " 0.6"))

    lines = [line for line in printed(tmp_path).splitlines() if "first" in line]

    assert "second [b]" in printed(tmp_path)
    *tables, reading = lines
    people, patterns = ([cell.strip() for cell in line.split("│")] for line in tables)
    assert people[2:6] == ["2", "9", "2/2", "1.00 ± 0.00"]
    assert patterns[2:7] == ["0", "0", "0", "2 (0.54)", "0"]  # hypot(0.2, 0.5), sampled at 4.4 s
    assert reading == (
        "first: read as id frame x y (recognized from the values), units m (guess: people walk), "
        "fps 10 (comment)"
    )


def test_single_file_can_be_described(tmp_path: Path) -> None:
    (tmp_path / "first.txt").write_text(GOOD)
    (tmp_path / "second.txt").write_text("nonsense")

    assert "second" not in printed(tmp_path / "first.txt")


def test_faults_are_told_after_the_good_ones_are_printed(tmp_path: Path) -> None:
    (tmp_path / "good.txt").write_text(GOOD)
    (tmp_path / "bad.csv").write_text("frame,id,x,y\n1,2,3\n")
    (tmp_path / "worse.csv").write_text("frame,id,x,y\n1,2,a,3\n")
    out = io.StringIO()

    with refused("bad.csv ... ; worse.csv"):
        describe(tmp_path, output_console(out, width=140))

    assert "good" in out.getvalue()


def test_jumping_tracks_and_lone_descriptions_are_remarked_on(tmp_path: Path) -> None:
    (tmp_path / "jumps.txt").write_text(GOOD + "1 91 20 0\n")
    (tmp_path / "lone.json").write_text("{}")

    text = printed(tmp_path)

    assert "warning: jumps: 1 " in text
    assert "note: lone.json" in text


def test_a_name_of_a_file_is_on_one_line(tmp_path: Path) -> None:
    (tmp_path / "a\nwarning: b\x1b[2J.txt").write_text(GOOD)

    assert "\na warning: b?[2J: read as" in printed(tmp_path / "a\nwarning: b\x1b[2J.txt")


def test_options_are_used_and_said(tmp_path: Path) -> None:
    (tmp_path / "first.txt").write_text(GOOD)
    out = io.StringIO()
    describe(
        tmp_path, output_console(out, width=140), Options(fps=12, units="m", columns="id frame x y")
    )

    text = out.getvalue()
    assert "id frame x y (option), units m (option), fps 12 (option)" in text
    says(text.replace("\n", " "), "warning: first: fps ... 12 ... 10")


def test_copies_and_improbable_recordings_are_warned_about(tmp_path: Path) -> None:
    (tmp_path / "first.txt").write_text(GOOD)
    (tmp_path / "second.txt").write_text(GOOD)
    (tmp_path / "slow.txt").write_text(GOOD)
    (tmp_path / "slow.json").write_text('{"fps": 1, "units": "m"}')

    text = printed(tmp_path)

    assert "warning: second" in text
    assert "warning: slow: " in text
