"""rl-zoo3 trains a policy with the settings of ``configs/rl_zoo3``, and shows it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rl_zoo3")

pytestmark = [pytest.mark.clients, pytest.mark.slow]

SETTINGS = Path(__file__).parents[2] / "configs" / "rl_zoo3" / "ppo.yml"
WHAT = ["--algo", "ppo", "--env", "hazbot_gym/Corridor-v1", "--gym-packages", "hazbot_gym"]


def zoo(command: str, *arguments: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-m", f"rl_zoo3.{command}", *WHAT, "-f", "logs", *arguments],
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_policy_is_trained_and_shown(tmp_path: Path) -> None:
    small = ["n_envs:2", "n_steps:16", "batch_size:16"]
    zoo(
        "train", "--conf-file", str(SETTINGS), "-n", "64", "--eval-freq", "-1", "-params", *small,
        folder=tmp_path,
    )  # fmt: skip
    shown = zoo("enjoy", "-n", "300", "--no-render", folder=tmp_path)
    assert "Episode Reward" in shown
