"""What policies are held against: the best that could have been done in a scenario, as an episode.

Where people do not react and the drive does what it is told, that is the exact optimum
(``dynamic_programming.py``), a bound for all policies whose commands lie on its speeds. Elsewhere
it is the best that a search in the simulator finds from what the policies of the study did
(``trajectory_search.py``). Both know the future.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.core.state import Floats
from hazbot_gym.evaluation import batch_rollout
from hazbot_gym.evaluation.episode import Episode
from hazbot_gym.evaluation.metrics import SsmThresholds, measure
from hazbot_gym.evaluation.open_loop import Plan
from hazbot_gym.evaluation.oracle import trajectory_search
from hazbot_gym.evaluation.oracle.dynamic_programming import is_exact_for, optimum
from hazbot_gym.evaluation.rollout import episode_seed, resolve, scenario_id
from hazbot_gym.evaluation.scenario_set import ScenarioSet
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.policies.base import make as make_policy
from hazbot_gym.task.scenario import Source


class Stretch(NamedTuple):
    """Some consecutive scenarios of a set whose yardstick is wanted: a unit of work."""

    scenarios: ScenarioSet
    first: int
    episodes: int
    seed: int
    specs: tuple[str, ...]  # of the policies that a search begins with
    effort: trajectory_search.Effort = trajectory_search.Effort()
    ssm: SsmThresholds = SsmThresholds()
    allowed: Permissions = NO_CODE  # what the policies may run


def run_stretch(stretch: Stretch) -> list[dict[str, Any]]:
    """Return a row for each scenario: the best drive, measured as episodes are.

    ``bound`` is what it earns, ``is_exact`` whether nobody could earn more, and ``actions`` the
    plan, in [-1, 1].
    """
    config, limit = resolve(stretch.scenarios)
    indices = range(stretch.first, stretch.first + stretch.episodes)
    seeds = [episode_seed(stretch.seed, stretch.scenarios.name, index) for index in indices]
    is_exact = is_exact_for(config)
    best = _exact(config, seeds) if is_exact else _searched(config, seeds, stretch)
    longest = max(len(found.actions) for found in best)
    plans = np.stack([_lengthened(found.actions, longest) for found in best])
    played = batch_rollout.run_episodes(config, Plan(plans), seeds, limit=limit, threads=1)
    return [
        {
            "scenario_set": stretch.scenarios.name,
            "episode": index,
            "seed": seed,
            "scenario": scenario_id(stretch.scenarios.name, index),
            "is_exact": int(is_exact),
            "bound": found.value,
            "actions": found.actions.tolist(),
            **labels,
            **measure(episode, stretch.ssm),
        }
        for index, seed, found, (episode, labels) in zip(indices, seeds, best, played, strict=True)
    ]


def _exact(config: Config, seeds: Sequence[int]) -> list[trajectory_search.Found]:
    """Return the optimum of each scenario, as a plan."""
    still = Plan(np.array([-1.0]))
    runs = batch_rollout.run_episodes(config, still, seeds, limit=1, threads=1)
    keys = [int(labels["scenario_key"]) for _, labels in runs]
    source = Source(config)
    found = [optimum(config, source.draw(key), key, with_speeds=True) for key in keys]
    return [
        trajectory_search.Found(_actions(each.speeds_mps, config), each.value) for each in found
    ]


def _searched(
    config: Config, seeds: Sequence[int], stretch: Stretch
) -> list[trajectory_search.Found]:
    """Return the best plan that is found for each scenario, from what the policies did."""
    limit = config.max_episode_steps
    policies = [make_policy(spec, **stretch.allowed._asdict()) for spec in stretch.specs]
    drives = [
        [
            _lengthened(_commanded(episode, config), limit)
            for episode, _ in batch_rollout.run_episodes(
                config, policy, seeds, limit=limit, threads=1
            )
        ]
        for policy in policies
    ]
    return [
        trajectory_search.search(
            config, seed, np.stack(starts), np.random.default_rng(seed), stretch.effort
        )
        for seed, starts in zip(seeds, zip(*drives, strict=True), strict=True)
    ]


def _commanded(episode: Episode, config: Config) -> Floats:
    return _actions(episode.command_mps[1:], config)


def _actions(speeds_mps: Floats, config: Config) -> Floats:
    """Return speeds as actions in [-1, 1]."""
    actions: Floats = 2.0 * speeds_mps / config.drive.nominal_speed_mps - 1.0
    return actions.clip(-1.0, 1.0)


def _lengthened(actions: Floats, length: int) -> Floats:
    """Return a plan that drives on at full speed where it would have ended."""
    return np.concatenate([actions, np.ones(length - len(actions))])
