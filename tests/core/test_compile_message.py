from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import hazbot_gym
from hazbot_gym.core.compile_message import COMPILE_MESSAGE, MESSAGE, CompileMessage
from hazbot_gym.evaluation.workers import processes

# The kernel that compiles fastest, and how often it came from the cache.
COMMAND = """
from hazbot_gym.core import fuzzy_pid
fuzzy_pid.gain_table()
print(sum(fuzzy_pid._tabulate.stats.cache_hits.values()), fuzzy_pid.__file__)
"""


def compilation_of(module: str) -> Any:
    function = SimpleNamespace(__module__=module)
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})


def run(folder: Path, **environment: str) -> tuple[int, str, str]:
    """Run the command in a folder; return its two words and what was said on stderr."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND],
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,  # Python looks there first
        env={**os.environ, **environment},
    )
    hits, file = done.stdout.split(maxsplit=1)
    return int(hits), file.strip(), done.stderr


def test_first_compilation_is_announced_and_no_other(caplog: pytest.LogCaptureFixture) -> None:
    listener = CompileMessage()
    for module in ("somebody.else", "hazbot_gym.core.fuzzy", "hazbot_gym.sim.drive"):
        listener.on_start(compilation_of(module))
        listener.on_end(compilation_of(module))

    assert [record.getMessage() for record in caplog.records] == [MESSAGE]


def test_compiling_is_said_once_and_the_cache_is_silent(tmp_path: Path) -> None:
    first = run(tmp_path, NUMBA_CACHE_DIR=str(tmp_path))
    second = run(tmp_path, NUMBA_CACHE_DIR=str(tmp_path))

    assert (first[0], first[2]) == (0, MESSAGE + "\n")
    assert (second[0], second[2]) == (1, "")


def test_compiling_is_not_said_again_by_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    for has_spoken, said in ((True, ""), (False, MESSAGE + "\n")):
        monkeypatch.setattr(COMPILE_MESSAGE, "has_spoken", has_spoken)
        with processes(1) as pool:
            pool.submit(exec, COMMAND).result()
        assert capfd.readouterr().err == said
        shutil.rmtree(tmp_path)


def test_kernels_are_cached_elsewhere_where_the_package_folder_cannot_be_written(
    tmp_path: Path,
) -> None:
    package = Path(hazbot_gym.__file__).parent
    copy = tmp_path / "site" / "hazbot_gym"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    # A file where the folder of caches would be stops the superuser too, unlike permissions.
    (copy / "core" / "__pycache__").write_text("")
    paths = {"PYTHONPATH": str(copy.parent), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    paths["NUMBA_CACHE_DIR"] = ""  # numba's default

    (first, file, _), (second, _, _) = run(tmp_path, **paths), run(tmp_path, **paths)

    assert Path(file).is_relative_to(copy)
    assert (first, second) == (0, 1)
    assert list((tmp_path / "cache").rglob("*_tabulate*.nbi"))
