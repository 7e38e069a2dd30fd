from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from hazbot_gym.utils.after_import import after_import


@pytest.fixture
def late(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of a module that can be imported and is not."""
    (tmp_path / "late_module.py").write_text("value = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path])
    monkeypatch.delitem(sys.modules, "late_module", raising=False)
    return "late_module"


def test_the_function_is_called_once_behind_the_import(late: str) -> None:
    seen: list[int] = []
    after_import(late, lambda: seen.append(sys.modules[late].value))
    before, finders = list(seen), len(sys.meta_path)

    for _ in range(2):
        __import__(late)
    assert (before, seen) == ([], [3])
    assert len(sys.meta_path) == finders - 1


def test_it_is_called_at_once_if_the_module_is_there() -> None:
    calls: list[str] = []
    after_import("sys", lambda: calls.append("called"))
    assert calls == ["called"]


def test_a_module_that_fails_is_waited_for(
    late: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    after_import(late, lambda: calls.append("called"))
    source = tmp_path / "late_module.py"
    source.write_text("raise RuntimeError('not yet')\n")
    with pytest.raises(RuntimeError, match="not yet"):
        __import__(late)
    assert calls == []

    source.write_text("value = 30\n")
    __import__(late)
    assert calls == ["called"]


@pytest.mark.parametrize("first", ["gymnasium", "hazbot_gym"])
def test_environments_are_registered_in_either_order(first: str) -> None:
    second = ({"gymnasium", "hazbot_gym"} - {first}).pop()
    code = f"import {first}, {second}; print(gymnasium.spec('hazbot_gym/Corridor-v1').id)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "hazbot_gym/Corridor-v1\n"
