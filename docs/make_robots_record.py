"""Drive several robots in an intersection: ``python docs/make_robots_record.py``.

Writes ``benchmarks/robots.json``. Needs the extra ``robots``; some minutes on one core.
"""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from hazbot_gym.config import make_config
from hazbot_gym.envs.robots import CorridorParallelEnv
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json
from hazbot_gym.utils.json_object import JsonObject

RECORD = Path(__file__).parents[1] / "benchmarks" / "robots.json"
PLACE, EPISODES, ROBOTS = "intersection", 20, (2, 4, 6)
POLICIES = ("fuzzy_expert", "ppo", "velocity_obstacle:margin_m=0.2")


def record() -> JsonObject:
    """Return the record: for each number of robots and policy, the end of each robot's episode."""
    return {
        "commit": provenance.commit(),
        "versions": provenance.versions() | {"pettingzoo": version("pettingzoo")},
        "place": PLACE,
        "episodes": EPISODES,
        "horizon_s": make_config(None).max_episode_steps * make_config(None).clock.decision_s,
        "runs": [
            {"robots": robots, "policy": policy, "ends": _ends(robots, policy)}
            for robots in ROBOTS
            for policy in POLICIES
        ],
    }


def _ends(robots: int, policy: str) -> list[JsonObject]:
    """Return a row for each robot of each episode; the seeds are the same for all policies."""
    env, driver = CorridorParallelEnv(robots, place=PLACE), make_policy(policy)
    rows = []
    for seed in range(EPISODES):
        for name, info in episode(env, driver, seed).items():
            kept = ("outcome", "contact_caused_by", "time_s", "time_free_s")
            rows.append({"seed": seed, "robot": name} | {key: info[key] for key in kept})
    return rows


def episode(env: CorridorParallelEnv, policy: Policy, seed: int) -> dict[str, dict[str, Any]]:
    """Drive all robots by one policy; return the last info of each."""
    seen, infos = env.reset(seed=seed)
    starts, state = np.ones(len(seen), np.bool_), None
    while env.agents:
        actions, state = policy.predict(
            np.stack(list(seen.values())), state=state, episode_start=starts, deterministic=True
        )
        chosen = dict(zip(seen, actions, strict=True))
        observations, *_, told = env.step({name: chosen[name] for name in env.agents})
        seen, infos = seen | observations, infos | told  # robots that are gone keep their last
        starts = np.zeros(len(seen), np.bool_)
    return infos


if __name__ == "__main__":
    write_json(RECORD, record())
