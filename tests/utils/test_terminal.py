from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest
from rich.table import Column
from rich.text import Text

from hazbot_gym.utils import terminal
from hazbot_gym.utils.terminal import FittedTable, output_console, progress_bar
from tests.refusals import says

WIDE = ("name", "first", "second", "third")


def encoded(encoding: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(), encoding=encoding)


def printed(*shown: object, width: int) -> str:
    out = io.StringIO()
    output_console(out, width=width).print(*shown)
    return out.getvalue()


def table(*, spare: tuple[str, ...] | None = None) -> FittedTable:
    made = FittedTable(Column("name", overflow="fold"), *WIDE[1:], box=None, spare=spare)
    made.add_row("learned:path=a/very/long/path.npz", "0.123..0.456", "1.5..2.5", "-21..126")
    return made


@pytest.mark.parametrize("encoding", ["ascii", "cp1251", "cp932", "gbk", "latin-1"])
def test_letters_that_an_encoding_lacks_are_replaced(encoding: str) -> None:
    out = encoded(encoding)
    output_console(out).print("m² é \udcff 火")
    out.flush()

    shown = out.buffer.getvalue().decode(encoding)  # type: ignore[attr-defined]
    assert shown.startswith(("m2 ", "m² "))
    assert "\\u" not in shown


def test_a_stream_that_is_set_to_something_else_is_left_so() -> None:
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="backslashreplace")
    output_console(out).print("m²")
    out.flush()

    assert out.buffer.getvalue() == b"m\\xb2\n"  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["o[/x]", "[bold]", "[red]a[/red]", ":dog:", "a[link=b]c"])
def test_brackets_and_colons_of_a_name_are_printed_as_they_stand(name: str) -> None:
    made = FittedTable("name", title=name)
    made.add_row(name)

    assert printed(name, width=80) == f"{name}\n"
    assert printed(made, width=80).count(name) == 2


@pytest.mark.parametrize(
    "name", ["a\x1b[31mb", "a\x1b]0;title\x07b", "a\u202eb", "a\x9b2Jb", "a\rb"]
)
def test_no_name_controls_the_terminal(name: str) -> None:
    made = FittedTable(Column(name), title=name, box=None)
    made.add_row(name)
    shown = printed(name, made, width=80)

    assert shown.replace("\n", "").isprintable()
    assert shown.count("a?") == 4


SAYS_TWICE = """
import sys, warnings
from hazbot_gym.errors import DoubtfulPlace
from hazbot_gym.utils import terminal
terminal.warn_in_one_line()
for _ in range(2):
    warnings.warn("my\\n\x1b[31mlab: too narrow", DoubtfulPlace)
    warnings.simplefilter("always")
warnings.warn("another")
"""


def test_a_doubt_is_one_line_and_said_once() -> None:
    done = subprocess.run([sys.executable, "-c", SAYS_TWICE], capture_output=True, text=True)

    first, second, *_ = done.stderr.splitlines()
    says(first, "warning ... my ?[31mlab ... too narrow")
    assert second.endswith("UserWarning: another")


def test_a_table_shows_everything_where_there_is_room() -> None:
    shown = printed(table(), width=120)

    assert all(title in shown for title in WIDE)


def test_the_last_columns_are_left_out_and_named_where_there_is_none() -> None:
    shown = printed(table(), width=40)

    assert "0.123..0.456" in shown
    assert "-21..126" not in shown
    assert "third." in shown


def test_spare_columns_are_left_out_in_their_order() -> None:
    shown = printed(table(spare=("first", "third")), width=40)

    assert "first." in shown
    assert "1.5..2.5" in shown
    assert "-21..126" in shown


@pytest.mark.parametrize("width", [*range(1, 30), 40, 60, 80])
def test_no_line_is_wider_than_the_console_and_no_number_broken(width: int) -> None:
    lines = printed(table(), width=width).splitlines()

    assert max(map(len, lines)) <= width
    numbers = [text for text in ("0.123..0.456", "1.5..2.5", "-21..126") if text in str(lines)]
    assert sum(line.count("..") for line in lines) == len(numbers)


@pytest.mark.parametrize("width", range(12, 60))
def test_nothing_is_cut_off_where_no_column_may_be_left_out(width: int) -> None:
    made = FittedTable(*WIDE, box=None, pad_edge=False, spare=())
    made.add_row("directional", "0.123", "1234", "-1.5")
    letters = "".join(printed(made, width=width).split())

    assert sorted(letters) == sorted("".join((*WIDE, "directional", "0.123", "1234", "-1.5")))


@pytest.mark.parametrize("width", range(5, 60))
def test_columns_that_are_left_keep_their_padding(width: int) -> None:
    made = FittedTable(*WIDE, box=None, pad_edge=False, spare=("name", "second"))
    made.add_row("directional", "0.123", "1234", "-1.5")

    assert "…" not in printed(made, width=width)


def test_a_long_name_folds_and_is_whole() -> None:
    lines = printed(table(), width=40).splitlines()[1:-1]

    assert "".join(line.split()[0] for line in lines) == "learned:path=a/very/long/path.npz"


def test_styled_cells_are_measured_as_their_text() -> None:
    made = FittedTable("a", Column("b", no_wrap=True), box=None)
    made.add_row("x", Text.assemble("12 ", ("34", "dim")))

    assert "12 34" in printed(made, width=11)


def test_piped_output_is_wide_and_a_terminal_as_wide_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    out = io.StringIO()
    assert output_console(out).width == terminal.PIPED_WIDTH
    monkeypatch.setattr(out, "isatty", lambda: True)
    assert output_console(out).width == 60
    monkeypatch.setenv("COLUMNS", "0")
    assert output_console(out).width == terminal.PIPED_WIDTH


def test_a_progress_bar_writes_nothing_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    out = io.StringIO()
    with progress_bar(output_console(out)) as progress:
        progress.advance(progress.add_task("a[/b]", total=2))

    assert out.getvalue() == ""


@pytest.mark.parametrize("encoding", ["ascii", "gbk"])
def test_hazbot_lists_and_complains_in_every_encoding(encoding: str) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    for arguments, code in ((["list"], 0), (["report", "é\udcff²"], 2), (["--help"], 0)):
        done = subprocess.run(
            [sys.executable, "-m", "hazbot_gym", *arguments],
            capture_output=True,
            check=False,
            env=environment,
        )
        assert done.returncode == code
        assert b"Traceback" not in done.stderr
        done.stdout.decode(encoding)
