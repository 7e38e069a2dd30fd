"""Run a script of CleanRL under Gymnasium 1, as it is.

In a checkout of CleanRL, with tyro and tensorboard installed:

    python .../cleanrl.py cleanrl/ppo_continuous_action.py --env-id hazbot_gym/Corridor-v1

CleanRL's scripts are written for Gymnasium 0.29, whatever the environment. Gymnasium 1 resets a
vector environment one step later, has the last observations and infos under other names, and asks
for an observation space in ``TransformObservation``. This file gives the scripts what they expect.
"""

import runpy
import sys
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium import vector, wrappers

import hazbot_gym  # noqa: F401  (registers the environments)


class SyncVectorEnv(vector.SyncVectorEnv):
    """Vector environment that resets and reports ends as that of Gymnasium 0.29."""

    def __init__(self, env_fns: Any) -> None:
        super().__init__(env_fns, autoreset_mode=vector.AutoresetMode.SAME_STEP)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Step; ``final_observation`` and ``final_info`` have an entry for each environment."""
        *found, infos = super().step(actions)
        if "final_info" in infos:
            statistics = infos["final_info"]["episode"]
            infos["final_observation"] = infos["final_obs"]
            infos["final_info"] = [
                {"episode": {name: statistics[name][i] for name in "rlt"}} if has_ended else None
                for i, has_ended in enumerate(infos["_final_info"])
            ]
        return *found, infos


def transform_observation(env: gymnasium.Env, func: Any) -> gymnasium.Env:
    """Wrap an environment whose observation space stays the same."""
    return TransformObservation(env, func, env.observation_space)


if __name__ == "__main__":
    TransformObservation = wrappers.TransformObservation
    wrappers.TransformObservation = transform_observation
    vector.SyncVectorEnv = SyncVectorEnv
    script = Path(sys.argv[1]).resolve()
    sys.argv = sys.argv[1:]
    sys.path.insert(0, str(script.parents[1]))  # cleanrl_utils
    runpy.run_path(str(script), run_name="__main__")
