"""``examples/cleanrl.py`` gives a script the vector environment of Gymnasium 0.29."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RUNNER = Path(__file__).parents[2] / "examples" / "cleanrl.py"
SCRIPT = """
import sys
import gymnasium as gym
import numpy as np

def make():
    env = gym.make(sys.argv[1], max_episode_steps=20)
    env = gym.wrappers.RecordEpisodeStatistics(env)
    return gym.wrappers.TransformObservation(env, lambda obs: np.clip(obs, -10, 10))

envs = gym.vector.SyncVectorEnv([make, make])
envs.reset(seed=1)
for step in range(45):
    obs, _, _, truncations, infos = envs.step(np.ones((2, 1), np.float32))
    if truncations.any():
        assert (infos["final_observation"][0] != obs[0]).any()
        print(step, [int(info["episode"]["l"]) for info in infos["final_info"]])
"""


def test_a_script_of_gymnasium_0_29_sees_ends_where_they_are(tmp_path: Path) -> None:
    script = tmp_path / "scripts" / "some.py"
    script.parent.mkdir()
    script.write_text(SCRIPT)
    command = [sys.executable, RUNNER, script, "hazbot_gym/Corridor-v1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines() == ["19 [20, 20]", "39 [20, 20]"], done.stderr
