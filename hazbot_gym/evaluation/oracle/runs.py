"""Oracle runs: the best known drive of each scenario, as an episode.

If people do not react and the drive is ideal, the oracle is the exact optimum
(``dynamic_programming.py``), an upper bound for policies with commands on its speeds. Otherwise it
is the result of an offline trajectory search started from the study's policies
(``trajectory_search.py``). Both know the future.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import measure
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.oracle import trajectory_search
from hazbot_gym.evaluation.oracle.dynamic_programming import is_exact_for, optimum
from hazbot_gym.evaluation.rollout import episode_seed, resolve, scenario_id
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.task.action import action_of_speed
from hazbot_gym.task.scenario import ScenarioSampler


class OracleShard(NamedTuple):
    """Consecutive scenarios of a set for the oracle: a unit of work."""

    scenarios: ScenarioSet
    first: int
    episodes: int
    seed: int
    specs: tuple[str, ...]  # policies whose actions initialize the search
    effort: trajectory_search.Effort = trajectory_search.Effort()
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
    is_exact = is_exact_for(config)
    best = _exact(config, seeds) if is_exact else _searched(config, seeds, shard)
    longest = max(len(found.actions) for found in best)
    plans = np.stack([lengthened(found.actions, longest) for found in best])
    played = batch_rollout.run_episodes(config, Plan(plans), seeds, limit=limit, threads=1)
    return [
        {
            "scenario_set": shard.scenarios.name,
            "episode": index,
            "seed": seed,
            "scenario": scenario_id(shard.scenarios.name, index),
            "is_exact": int(is_exact),
            "bound": found.value,
            "actions": found.actions.tolist(),
            **labels,
            **measure(episode, shard.ssm),
        }
        for index, seed, found, (episode, labels) in zip(indices, seeds, best, played, strict=True)
    ]


def _exact(config: Config, seeds: Sequence[int]) -> list[trajectory_search.Found]:
    """Return the optimum of each scenario, as a plan."""
    still = Plan(np.array([-1.0]))
    runs = batch_rollout.run_episodes(config, still, seeds, limit=1, threads=1)
    keys = [int(labels["scenario_key"]) for _, labels in runs]
    source = ScenarioSampler(config)
    found = [optimum(config, source.draw(key), key, with_speeds=True) for key in keys]
    return [
        trajectory_search.Found(
            action_of_speed(each.speeds_mps, config.drive.nominal_speed_mps), each.value, each.value
        )
        for each in found
    ]


def _searched(
    config: Config, seeds: Sequence[int], shard: OracleShard
) -> list[trajectory_search.Found]:
    """Return the best plan found for each scenario, starting from the policies' actions."""
    limit = config.max_episode_steps
    policies = [make_policy(spec, **shard.allowed._asdict()) for spec in shard.specs]
    drives = [
        [
            lengthened(_commanded(episode, config), limit)
            for episode, _ in batch_rollout.run_episodes(
                config, policy, seeds, limit=limit, threads=1
            )
        ]
        for policy in policies
    ]
    return [
        trajectory_search.search(
            config, seed, np.stack(starts), np.random.default_rng(seed), shard.effort
        )
        for seed, starts in zip(seeds, zip(*drives, strict=True), strict=True)
    ]


def _commanded(episode: Episode, config: Config) -> Floats:
    return action_of_speed(episode.command_mps[1:], config.drive.nominal_speed_mps)


def lengthened(actions: Floats, length: int) -> Floats:
    """Return a plan extended at full speed."""
    return np.concatenate([actions, np.ones(length - len(actions))])
