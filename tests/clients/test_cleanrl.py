"""CleanRL's scripts for continuous actions run as they are, by ``examples/cleanrl.py``.

CleanRL is no package for this Python: set CLEANRL to a checkout of its repository.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("tyro")

pytestmark = [pytest.mark.clients, pytest.mark.slow]

RUNNER = Path(__file__).parents[2] / "examples" / "cleanrl.py"
SCRIPTS = {
    "ppo_continuous_action": ["--num-envs", "2", "--num-steps", "512"],
    "sac_continuous_action": ["--learning-starts", "1300", "--buffer-size", "2000"],
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_runs_as_it_is(name: str, tmp_path: Path) -> None:
    if "CLEANRL" not in os.environ:
        pytest.skip("set CLEANRL to a checkout of CleanRL")
    script = Path(os.environ["CLEANRL"]) / "cleanrl" / f"{name}.py"
    limits = ["--total-timesteps", "1400", "--no-cuda", *SCRIPTS[name]]
    done = subprocess.run(
        [sys.executable, RUNNER, script, "--env-id", "hazbot_gym/Corridor-v1", *limits],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "episodic_return=" in done.stdout
