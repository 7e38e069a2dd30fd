"""Policies of the user's own: where their modules are looked for, and what their mistakes say."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from hazbot_gym import policies
from tests.refusals import refused

POLICY = """
import helper_of_mine

class Mine:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return [helper_of_mine.ANSWER], state
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a working folder with a policy in it; what is imported from it is forgotten."""
    monkeypatch.chdir(tmp_path)
    before, modules = list(sys.path), dict(sys.modules)
    monkeypatch.setattr(sys, "path", [place for place in sys.path if place])
    (tmp_path / "mine_here.py").write_text(POLICY)
    (tmp_path / "helper_of_mine.py").write_text("ANSWER = 3\n")
    yield tmp_path
    sys.path[:] = before
    for name in sys.modules.keys() - modules.keys():
        del sys.modules[name]


def test_the_working_folder_is_on_the_path_only_while_a_module_is_imported() -> None:
    before = list(sys.path)

    assert policies.make("mine_here:Mine").predict([0.0]) == (3, None)  # type: ignore[arg-type]

    assert sys.path == before
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("another_here")


@pytest.mark.parametrize(
    ("command", "files"),
    [
        (["-P", "-c", "from hazbot_gym.cli import main; main()"], ["numpy", "rich", "socket"]),
        (["-m", "hazbot_gym"], []),  # Python itself puts the folder first until the library runs
    ],
)
def test_no_file_of_the_working_folder_takes_the_place_of_a_library(
    command: list[str], files: list[str], folder: Path
) -> None:
    for name in ("yaml", *files):
        (folder / f"{name}.py").write_text("raise SystemExit('run from the working folder')\n")
    (folder / "mine_here.py").write_text("import yaml\n" + POLICY)

    done = subprocess.run(
        [sys.executable, *command, "eval", "--policy", "mine_here:missing"],
        capture_output=True,
        text=True,
    )

    assert (done.returncode, done.stdout) == (2, "")
    # It is said that the file was passed over.
    said = "hazbot: policy: 'mine_here:missing' imports the installed module 'yaml' ("
    assert done.stderr.startswith(said)
    assert "'yaml.py'" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("where", ["mine_here.py", "helper_of_mine.py"])
def test_a_helper_with_the_name_of_an_installed_module_is_not_passed_over_silently(
    where: str, folder: Path
) -> None:
    (folder / "colorsys.py").write_text("SPEED = 1\n")
    (folder / "not_imported.py").write_text("import colorsys\n")
    assert policies.make("mine_here:Mine") is not None
    for name in ("mine_here", "helper_of_mine"):
        del sys.modules[name]

    (folder / where).write_text((folder / where).read_text() + "from colorsys import rgb_to_hls\n")
    with refused("'colorsys' ... colorsys.py"):
        policies.make("mine_here:Mine")


@pytest.mark.parametrize(
    ("name", "spec"),
    [("yaml.py", "yaml:P"), ("yaml", "yaml.inner:P"), ("json.py", "json:P"), ("sys.py", "sys:P")],
)
def test_a_module_with_the_name_of_an_installed_one_is_refused(
    name: str, spec: str, folder: Path
) -> None:
    local = folder / name
    local.write_text("P = 3\n") if local.suffix else local.mkdir()

    top = spec.partition(":")[0].partition(".")[0]
    with refused(f"'{top}' ... '{name}'"):
        policies.make(spec)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("\nx = 1 / 0\n", "ZeroDivisionError: division by zero (line 2 of {file})"),
        ("import not_installed_anywhere", "ModuleNotFoundError: No module named 'not_installed"),
        ("def f(:\n", "SyntaxError: invalid syntax (broken.py, line 1) (line 1 of {file})"),
        ("import sys; sys.exit(0)", "SystemExit: 0 (line 1 of {file})"),
        ("raise ValueError('a\\nb')", "ValueError: a"),
        ("import json; json.loads('{')", "JSONDecodeError: "),
        ("from broken import broken", "ImportError: cannot import name 'broken'"),
    ],
)
def test_a_module_that_fails_says_with_what_and_where(code: str, said: str, folder: Path) -> None:
    (folder / "broken.py").write_text(code)

    with refused() as caught:
        policies.make("broken:P")

    start = "policy: importing 'broken' failed: "
    assert str(caught.value).startswith(start + said.format(file=folder / "broken.py"))
    assert "line 1 of" in str(caught.value) or "line 2 of" in str(caught.value)
    assert caught.value.__cause__ is not None  # Python shows where it comes from


def test_a_maker_that_fails_says_with_what_and_where(folder: Path) -> None:
    (folder / "maker.py").write_text("class P:\n    def __init__(self, x): pass\n    predict = 1\n")
    with refused("'maker:P' ... TypeError ... 'x'"):
        policies.make("maker:P")
