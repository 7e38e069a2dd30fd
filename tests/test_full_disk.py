"""Commands that write, on a disk that is full: one line, and no file half-written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from hazbot_gym.bench import run as bench
from hazbot_gym.cli import app
from hazbot_gym.study import tuning
from hazbot_gym.study.tuning import Record, Search, tune
from tests.refusals import says

resource = pytest.importorskip("resource", reason="needs limits on the size of files")

TRAINING = """
algorithm: ppo
worlds: 4
steps: 384
overrides: {max_episode_steps: 20}
options: {n_steps: 16, batch_size: 32, n_epochs: 1}
network: {net_arch: [64, 64]}
validation: {every_steps: 100, episodes: 2}
"""
STUDY = """
episodes: 1
policies: [constant]
sets: [Crossing]
"""
WATCH = "watch --policy constant --set max_episode_steps=20 --save"


@contextmanager
def room_for(size_bytes: int) -> Iterator[None]:
    """Let no file become larger than a size, as on a full disk."""
    usual, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (usual, most))


def run(arguments: str) -> tuple[int, str]:
    """Run the command line; return its exit code and the last line on stderr."""
    result = CliRunner().invoke(app, arguments.split())
    assert "Traceback" not in result.output
    return result.exit_code, result.stderr.splitlines()[-1]


def tune_in_one_set(search: Search, *arguments: Any, **options: Any) -> Record:
    return tune(search._replace(sets=search.sets[:1]), *arguments, **options)


@pytest.fixture(autouse=True)
def working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "training.yaml").write_text(TRAINING)
    (tmp_path / "study.yaml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tuning, "tune", tune_in_one_set)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "size_bytes", "file"),
    [
        ("study --config study.yaml --workers 1 --out new", 1_000, "new/manifest.json"),
        ("train --config training.yaml --out new", 1_000, "new/manifest.json"),
        ("train --config training.yaml --out new", 7_000, "new/policy.npz"),
        ("tune --policy ttc --trials 1 --out new", 200, "new"),
        (f"{WATCH} new.mp4", 2_000, "new.mp4"),
        (f"{WATCH} new.gif", 2_000, "new.gif"),
        (f"{WATCH} new.png", 2_000, "new.png"),
    ],
)
def test_one_line_names_the_file_which_is_not_left_half_written(
    arguments: str, size_bytes: int, file: str, working_folder: Path
) -> None:
    with room_for(size_bytes):
        code, line = run(arguments)
    assert code == 2
    says(line, f"hazbot: out ... '{file}'")
    assert not Path(file).exists()
    assert not list(working_folder.rglob("*.tmp"))


def test_a_measurement_that_cannot_be_kept_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "bench", lambda _: {"rates": [1.0] * 100})
    with room_for(100):
        code, line = run("bench --quick --json new.json")
    assert code == 2
    says(line, "hazbot: out ... 'new.json'")
    assert not Path("new.json").exists()


def test_the_thread_of_tensorboard_tells_no_traceback(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def write(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("tensorboard.summary.writer.record_writer.RecordWriter.write", write)
    code, line = run("train --config training.yaml --out new")
    assert code == 2
    says(line, "hazbot: out ... 'new' ... No space left on device")
    assert "Traceback" not in capfd.readouterr().err
