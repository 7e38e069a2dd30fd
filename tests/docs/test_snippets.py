"""Python snippets of README and site run as they are printed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from gymnasium import wrappers

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "docs/quickstart.md",
    "docs/own_policy.md",
    "docs/own_reward.md",
    "docs/own_people.md",
    "docs/randomise.md",
    "docs/own_observation.md",
    "docs/sensor_ring.md",
    "docs/nominal_speed.md",
    "docs/gas.md",
    "docs/gas_sensor.md",
    "docs/curriculum.md",
    "docs/clients.md",
    "docs/datasets.md",
    "docs/robots.md",
)
CLIENTS = ("sbx", "skrl", "tianshou", "torchrl")  # libraries that only make clients installs
SNIPPETS = [
    (page, snippet)
    for page in PAGES
    for snippet in re.findall(
        r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL
    )
]


def case(page: str, snippet: str) -> Any:
    """Return a snippet as a case of its last line, or of the client that it imports."""
    for client in CLIENTS:
        if re.search(rf"^(from|import) {client}\b", snippet, re.MULTILINE):
            others = pytest.mark.filterwarnings("default")
            return pytest.param(page, snippet, id=client, marks=[pytest.mark.clients, others])
    return pytest.param(page, snippet, id=f"{page}: {snippet.strip().splitlines()[-1][:40]}")


# Gymnasium works the bounds of RescaleAction out in float64 and warns that it stores float32.
@pytest.mark.filterwarnings("ignore:.*precision lowered by casting to float32")
@pytest.mark.slow
@pytest.mark.parametrize(("page", "snippet"), [case(*snippet) for snippet in SNIPPETS])
def test_a_snippet_runs_as_it_is_printed(
    page: str, snippet: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for optional in (*CLIENTS, "minari"):
        if re.search(rf"(from|import) {optional}", snippet):
            pytest.importorskip(optional)
    if "envs.robots" in snippet:
        pytest.importorskip("pettingzoo")
    if "train(" in snippet or "stable_baselines3" in snippet:
        pytest.importorskip("stable_baselines3")
    if "RecordVideo" in snippet and not hasattr(wrappers.vector, "RecordVideo"):
        pytest.skip("before 1.2.3 Gymnasium records no batches")
    monkeypatch.chdir(tmp_path)
    exec(compile(snippet, page, "exec"), {"__name__": "page"})


def test_there_are_snippets_on_every_page() -> None:
    assert {page for page, _ in SNIPPETS} == set(PAGES)
