from __future__ import annotations

import itertools
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
COMMANDS = re.findall(r"^make (\w+)", README, flags=re.MULTILINE)
INSTALL = re.findall(r"```sh\n(.*?)```", README, flags=re.DOTALL)[0]
HAZBOT = re.findall(r"`(hazbot [^`]+)`", README)


@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda text: text.strip().splitlines()[-1][:40])
def test_every_snippet_runs(snippet: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, "README.md", "exec"), {"__name__": "readme"})


def test_snippets_show_the_three_promised_things() -> None:
    assert len(SNIPPETS) >= 3
    for needed in ("env.step", "fuzzy_expert", "def predict"):
        assert any(needed in snippet for snippet in SNIPPETS)


def test_the_two_commands_are_targets_and_what_ci_runs() -> None:
    assert COMMANDS == ["study", "test"]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for command in COMMANDS:
        assert re.search(rf"^{command}:", makefile, flags=re.MULTILINE)
        assert f"make {command}" in ci


def test_the_install_block_clones_sets_up_and_makes_hazbot_reachable() -> None:
    lines = [line.partition("#")[0].strip() for line in INSTALL.splitlines()]
    assert [line for line in lines if line] == [
        "git clone ADDRESS hazbot_gym",
        "cd hazbot_gym",
        "make study",
        "make test",
        "source .venv/bin/activate",
        "hazbot --version",
    ]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert re.search(r"^BIN := \.venv/bin$", makefile, flags=re.MULTILINE)
    assert README.index(INSTALL) < min(map(README.index, SNIPPETS))


@pytest.mark.parametrize("command", sorted(set(HAZBOT)))
def test_every_hazbot_command_that_it_shows_has_these_options(command: str) -> None:
    _, *words = shlex.split(command)
    named = [word for word in words if word.startswith("--")]
    asked = CliRunner().invoke(app, [words[0], "--help"], env={"COLUMNS": "200"})
    assert asked.exit_code == 0
    assert all(name in asked.output for name in named)
    for name, value in itertools.pairwise(words):
        assert name != "--config" or (ROOT / value).is_file()


def test_the_policy_that_it_saves_as_a_module_prints_nothing_when_imported() -> None:
    snippet = next(text for text in SNIPPETS if "class StopWhenNear" in text)
    saved = snippet[: snippet.index("episode, _ =")]
    assert "print" not in saved
    assert "With its imports and the class saved in `mine.py`" in README


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 120


def test_every_file_that_it_names_is_there() -> None:
    links = re.findall(r"\]\(([^)]+)\)", README)
    for link in links:
        assert link.startswith("https://") or (ROOT / link).is_file()
