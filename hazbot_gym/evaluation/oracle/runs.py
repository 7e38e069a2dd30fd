"""Oracle runs: the best drive known of each scenario (``best_drives.py``), as an episode.

A search starts from the drives of the study's policies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.oracle.best_drives import optima, plan_of, searched
from hazbot_gym.evaluation.oracle.dynamic_programming import is_exact_for
from hazbot_gym.evaluation.oracle.trajectory_search import Effort, Found
from hazbot_gym.evaluation.rollout import episode_seed, resolve, scenario_id
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.policies.base import make as make_policy


class OracleShard(NamedTuple):
    """Consecutive scenarios of a set for the oracle: a unit of work."""

    scenarios: ScenarioSet
    first: int
    episodes: int
    seed: int
    specs: tuple[str, ...]  # policies whose actions initialize the search
    effort: Effort = Effort()
    ssm: SsmThresholds = SsmThresholds()
    allowed: Permissions = NO_CODE  # permissions of the policies


def run_oracle_shard(shard: OracleShard) -> list[dict[str, object]]:
    """Return one row per scenario: metrics of the best drive.

    ``bound`` is its return, ``is_exact`` marks a proven optimum, and ``actions`` is the plan in
    [-1, 1].
    """
    config, limit = resolve(shard.scenarios)
    indices = range(shard.first, shard.first + shard.episodes)
    seeds = [episode_seed(shard.seed, shard.scenarios.name, index) for index in indices]
    best = _best(config, seeds, shard)
    played = batch_rollout.run_episodes(config, plan_of(best), seeds, limit=limit, threads=1)
    return [
        {
            "scenario_set": shard.scenarios.name,
            "episode": index,
            "seed": seed,
            "scenario": scenario_id(shard.scenarios.name, index),
            "is_exact": int(is_exact_for(config)),
            "bound": found.value,
            "actions": found.actions.tolist(),
            **labels,
            **measure(episode, shard.ssm),
        }
        for index, seed, found, (episode, labels) in zip(indices, seeds, best, played, strict=True)
    ]


def _best(config: Config, seeds: Sequence[int], shard: OracleShard) -> list[Found]:
    """Return the best drive of each scenario."""
    if is_exact_for(config):
        still = Plan(np.array([-1.0]))
        runs = batch_rollout.run_episodes(config, still, seeds, limit=1, threads=1)
        return optima(config, [int(labels["scenario_key"]) for _, labels in runs])
    policies = [make_policy(spec, **shard.allowed._asdict()) for spec in shard.specs]
    limit = config.max_episode_steps
    drives = [
        [
            episode
            for episode, _ in batch_rollout.run_episodes(
                config, policy, seeds, limit=limit, threads=1
            )
        ]
        for policy in policies
    ]
    return searched(config, seeds, drives, shard.effort)
