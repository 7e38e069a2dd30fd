"""The scripts of ``eval/`` and ``train/`` run from top to bottom."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def run(script: str, *arguments: str, folder: Path) -> str:
    command = [sys.executable, str(ROOT / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_policy_is_evaluated(tmp_path: Path) -> None:
    text = run("eval/evaluate_policy.py", "--episodes", "1", folder=tmp_path)
    assert "kinetic_intrusion_m2" in text


def test_policies_are_compared(tmp_path: Path) -> None:
    arguments = ["constant:1.0", "constant:0.5", "--sets", "Crossing", "--episodes", "2"]
    text = run("eval/compare_policies.py", *arguments, folder=tmp_path)
    assert "Crossing: constant:0.5 minus constant:1.0" in text
    assert (tmp_path / "results" / "compare_policies" / "summary.json").exists()


@pytest.mark.slow
def test_ppo_starts_to_learn_and_is_saved(tmp_path: Path) -> None:
    run("train/ppo_quickstart.py", "--steps", "64", "--out", "ppo.zip", folder=tmp_path)
    assert (tmp_path / "ppo.zip").exists()
