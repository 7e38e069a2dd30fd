"""The page on robots, followed word by word."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "robot.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def test_every_step_of_the_page_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (robot,) = blocks("yaml")
    Path("robot.yaml").write_text(robot)
    names: dict[str, Any] = {}
    for snippet in blocks("python"):
        exec(compile(snippet, "robot.md", "exec"), names)

    _, first, second, stopped = capsys.readouterr().out.splitlines()
    assert first.endswith("None")
    near, alone = map(float, second.split())
    assert near < alone == 0.5
    assert stopped.startswith("0.0 Stop(cause='not finite'")
