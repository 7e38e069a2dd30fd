"""The page on other libraries says nothing that does not run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from gymnasium import wrappers

PAGE = (Path(__file__).parents[1] / "docs" / "clients.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(
    r"^## (.+?)$(?:(?!^## ).)*?```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE
)


# Gymnasium works the bounds of RescaleAction out in float64 and warns that it stores float32.
@pytest.mark.filterwarnings("ignore:.*precision lowered by casting to float32")
@pytest.mark.parametrize(("title", "snippet"), SNIPPETS, ids=[title for title, _ in SNIPPETS])
def test_a_snippet_runs_as_it_is_printed(
    title: str, snippet: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for optional in ("torchrl", "minari"):
        if f"from {optional}" in snippet:
            pytest.importorskip(optional)
    if "RecordVideo" in snippet and not hasattr(wrappers.vector, "RecordVideo"):
        pytest.skip("before 1.2.3 Gymnasium records no batches")
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, title, "exec"), {"__name__": "page"})


def test_every_snippet_is_run() -> None:
    assert len(SNIPPETS) == PAGE.count("```python")
