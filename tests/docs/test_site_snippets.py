"""Quickstart and how-to of the site say nothing that does not run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
SNIPPETS = [
    snippet
    for page in ("quickstart.md", "own_policy.md")
    for snippet in re.findall(
        r"```python\n(.*?)```", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL
    )
]


@pytest.mark.slow
@pytest.mark.parametrize("snippet", SNIPPETS, ids=lambda text: text.strip().splitlines()[-1][:40])
def test_a_snippet_runs_as_it_is_printed(
    snippet: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if "train(" in snippet:
        pytest.importorskip("stable_baselines3")
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, "docs", "exec"), {"__name__": "page"})


def test_there_are_snippets() -> None:
    assert len(SNIPPETS) == 6
