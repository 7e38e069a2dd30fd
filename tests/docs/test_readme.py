from __future__ import annotations

import itertools
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^make (\w+)", README, flags=re.MULTILINE)
HAZBOT = re.findall(r"`(hazbot [^`]+)`", README)


def test_its_commands_are_targets_and_what_ci_runs() -> None:
    assert {"study", "test"} <= set(COMMANDS)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in COMMANDS:
        assert re.search(rf"^{command}:", makefile, flags=re.MULTILINE)
        assert re.search(rf"^[^#\n]*make .*\b{command}\b", ci, flags=re.MULTILINE)


@pytest.mark.parametrize("command", sorted(set(HAZBOT)))
def test_every_hazbot_command_that_it_shows_has_these_options(command: str) -> None:
    _, *words = shlex.split(command)
    named = [word for word in words if word.startswith("--")]
    asked = CliRunner().invoke(app, [words[0], "--help"], env={"COLUMNS": "200"})
    assert asked.exit_code == 0
    assert all(name in asked.output for name in named)
    for name, value in itertools.pairwise(words):
        assert name != "--config" or (ROOT / value).is_file()


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 120
