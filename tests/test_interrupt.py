"""Ctrl-C, or an interrupt of the main process alone: one line says how to go on."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hazbot_gym.cli import app
from hazbot_gym.study import run as comparison
from hazbot_gym.study import tuning
from tests.refusals import says


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("command", "how"),
    [
        ("study", "interrupted ... again"),
        ("tune --policy ttc", "interrupted ... again"),
        ("train", "interrupted ... --resume"),
        ("eval --policy ttc", "interrupted"),
    ],
)
def test_an_interrupted_command_says_how_to_go_on(
    command: str, how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hazbot_gym.evaluation import rollout
    from hazbot_gym.training import run as training

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(comparison, "run_study", interrupt)
    monkeypatch.setattr(tuning, "tune", interrupt)
    monkeypatch.setattr(training, "train", interrupt)
    monkeypatch.setattr(rollout, "evaluate", interrupt)
    result = CliRunner().invoke(app, command.split())
    assert result.exit_code == 130
    says(result.stderr, how)


def test_a_command_that_is_asked_to_end_ends_in_order() -> None:
    code = (
        "import os, signal\n"
        "from hazbot_gym import cli\n"
        "from hazbot_gym.study import run\n"
        "run.run_study = lambda *_, **__: os.kill(os.getpid(), signal.SIGTERM)\n"
        "cli.main()\n"
    )
    command = [sys.executable, "-c", code, "study", "--no-report"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (143, "")
    says(done.stderr, "interrupted ... again")
