"""Drive several robots in an intersection: ``python docs/make_robots_record.py``.

Writes ``benchmarks/robots.json``. Needs the extra ``robots``; ten minutes on one core.
"""

from __future__ import annotations

from collections import Counter
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from hazbot_gym.config import make_config
from hazbot_gym.core.state import PRESENT, Records
from hazbot_gym.envs.robots import CorridorParallelEnv
from hazbot_gym.policies.base import Policy
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.policies.fuzzy_expert import SENSITIVE_M
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import write_json
from hazbot_gym.utils.json_object import JsonObject

RECORD = Path(__file__).parents[1] / "benchmarks" / "robots.json"
PLACE, EPISODES, ROBOTS = "intersection", 100, (2, 4, 6)
POLICIES = (
    "fuzzy_expert",
    "fuzzy_expert:rules=literal8",
    "ppo",
    "velocity_obstacle:margin_m=0.2",
)
DEFAULTS = make_config(None)
HORIZON_S = DEFAULTS.max_episode_steps * DEFAULTS.clock.decision_s


def record() -> JsonObject:
    """Return the record: for each number of robots and policy, the ends of the robots' episodes."""
    return {
        "commit": provenance.commit(),
        "versions": provenance.versions() | {"pettingzoo": version("pettingzoo")},
        "place": PLACE,
        "episodes": EPISODES,
        "horizon_s": HORIZON_S,
        "sensitive_m": SENSITIVE_M,
        "runs": [
            {"robots": robots, "policy": policy, **_summary(_ends(robots, policy))}
            for robots in ROBOTS
            for policy in POLICIES
        ],
    }


def _summary(ends: list[JsonObject]) -> JsonObject:
    """Return means and counts of robots; of episodes where it says so."""
    stuck = [end for end in ends if end["outcome"] == "timeout"]
    return {
        "delay_s": float(np.mean([_delay_s(end) for end in ends])),
        "outcomes": dict(Counter(end["outcome"] for end in ends)),
        "contacts_with_people_by_robot": sum(
            end["outcome"] == "contact_person" and end["contact_caused_by"] == "robot"
            for end in ends
        ),
        "episodes_with_deadlock": len({end["seed"] for end in stuck}),
        "stuck_near": dict(Counter(end["near"] for end in stuck)),
    }


def _delay_s(end: JsonObject) -> float:
    time_s: float = end["time_s"] if end["outcome"] == "arrived" else HORIZON_S
    return time_s - float(end["time_free_s"])


def _ends(robots: int, policy: str) -> list[JsonObject]:
    """Return a row for each robot of each episode; the seeds are the same for all policies."""
    env, driver = CorridorParallelEnv(robots, place=PLACE), make_policy(policy)
    rows = []
    for seed in range(EPISODES):
        infos = episode(env, driver, seed)
        near = _near(env, [name for name in infos if infos[name]["outcome"] == "timeout"])
        rows += [info | {"seed": seed, "near": near.get(name)} for name, info in infos.items()]
    return rows


def _near(env: CorridorParallelEnv, stuck: list[str]) -> dict[str, str]:
    """Return what is within R_s of each robot at the horizon: robots, people, both or nothing."""
    robots = env.robots[[env.possible_agents.index(name) for name in stuck]]
    people = env.people[env.people["status"] == PRESENT]
    names = {(True, True): "both", (True, False): "robot", (False, True): "person"}
    return {
        name: names.get(
            (_is_near(np.delete(robots, i), robots[i]), _is_near(people, robots[i])), "nothing"
        )
        for i, name in enumerate(stuck)
    }


def _is_near(others: Records, robot: Records) -> bool:
    away_m = np.hypot(others["x"] - robot["x"], others["y"] - robot["y"])
    return bool((away_m < SENSITIVE_M).any())


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
