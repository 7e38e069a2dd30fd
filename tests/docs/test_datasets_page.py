"""The comparison of ``docs/datasets.md`` is that of its record."""

from __future__ import annotations

from pathlib import Path

from hazbot_gym.utils.files import read_json

ROOT = Path(__file__).parents[2]


def test_page_has_the_numbers_of_the_record() -> None:
    page = (ROOT / "docs/datasets.md").read_text(encoding="utf-8")
    runs = read_json(ROOT / "benchmarks/offline.json")["runs"]
    assert len(runs) >= 2
    for run in runs:
        returns = (f"{run[who]['return']:.1f}" for who in ("recorded", "trained"))
        row = " | ".join((f"`{run['dataset']}`", f"`{run['method']}`", *returns))
        assert f"| {row} |" in page
