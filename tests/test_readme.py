from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
COMMANDS = re.findall(r"^make (\w+)", README, flags=re.MULTILINE)


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


def test_every_file_that_it_names_is_there() -> None:
    links = re.findall(r"\]\(([^)]+)\)", README)
    for link in links:
        assert link.startswith("https://") or (ROOT / link).is_file()
