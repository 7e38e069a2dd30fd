"""rl-zoo3 trains a policy with each file of settings in ``configs/rl_zoo3``, and shows it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rl_zoo3")

pytestmark = [pytest.mark.clients, pytest.mark.slow]

SETTINGS = sorted((Path(__file__).parents[2] / "configs" / "rl_zoo3").glob("*.yml"))
WHAT = ["--env", "hazbot_gym/Corridor-v1", "--gym-packages", "hazbot_gym", "-f", "logs"]
LEVELS = ["--env-kwargs", "action_type:'discrete'"]
SMALL = ["n_envs:2", "batch_size:16"]
ON_POLICY, OFF_POLICY = ["n_steps:16"], ["learning_starts:20", "buffer_size:200"]


def zoo(command: str, algorithm: str, *arguments: str, folder: Path) -> str:
    levels = LEVELS if algorithm == "qrdqn" else []
    done = subprocess.run(
        [
            sys.executable, "-m", f"rl_zoo3.{command}",
            "--algo", algorithm, *WHAT, *levels, *arguments,
        ],
        capture_output=True, text=True, check=False, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda path: path.stem)
def test_a_policy_is_trained_and_shown(settings: Path, tmp_path: Path) -> None:
    algorithm = settings.stem
    small = [*SMALL, *(ON_POLICY if algorithm.startswith("ppo") else OFF_POLICY)]
    zoo(
        "train", algorithm, "--conf-file", str(settings), "-n", "64", "--eval-freq", "-1",
        "-params", *small, folder=tmp_path,
    )  # fmt: skip
    shown = zoo("enjoy", algorithm, "-n", "300", "--no-render", folder=tmp_path)
    assert "Episode Reward" in shown
