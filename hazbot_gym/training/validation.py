"""Validation during training: metrics over held-out scenarios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np

from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.evaluation import batch_rollout, rollout
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.metrics import means, measure
from hazbot_gym.policies.base import Policy
from hazbot_gym.training.config import TrainConfig, split

ROOT = 0  # root of the seeds: all runs share the validation scenarios

Validated = dict[str, float | None]  # mean of each metric; None if undefined in all episodes


def validate(policy: Policy, config: TrainConfig, surcharge: float = 0.0) -> Validated:
    """Return the mean of each headline metric, and of the cost, over a run's validation scenarios.

    With several environments the mean return in each is there, too: ``return/Doorway-v1``. The name
    of a scenario set enters its seeds, and no set of a study has these names.

    Args:
        policy: A deterministic policy.
        config: Config of the run.
        surcharge: Price of nearness above that of the environments [s of delay per s of
            discomfort].
    """
    rows = dict[str, list[Row]]()
    episodes = split(config.validation.episodes, len(config.env))
    for env, each, count in zip(config.env, config.environments(), episodes, strict=True):
        seeds = [rollout.episode_seed(ROOT, f"validation of {env}", i) for i in range(count)]
        limit, threads = each.max_episode_steps, config.threads
        runs = batch_rollout.run_episodes(each, policy, seeds, limit=limit, threads=threads)
        found = [measure(episode, SsmThresholds()) for episode, _ in runs] if seeds else []
        rows.setdefault(env, []).extend(_at_price(row, surcharge) for row in found)
    pooled = [row for found in rows.values() for row in found]
    cost = float(np.mean([row["cost"] for row in pooled]))
    return {**means(pooled), "cost": cost, **(_by_env(rows) if len(rows) > 1 else {})}


def _at_price(row: Row, surcharge: float) -> Row:
    discomfort_s = cast(float, row["discomfort_s"])
    return {**row, "return": cast(float, row["return"]) - surcharge * discomfort_s}


def _by_env(rows: Mapping[str, Sequence[Row]]) -> Validated:
    """Return the mean return in each environment."""
    return {
        f"return/{env.rpartition('/')[2]}": _mean([cast(float, row["return"]) for row in found])
        for env, found in rows.items()
    }


def validate_at_prices(
    policies: Mapping[float, Policy], usual: float, config: TrainConfig
) -> Validated:
    """Return the means over several prices of nearness, with the return at each price.

    Args:
        policies: A policy for each price [s of delay per s of discomfort].
        usual: The price of the environments.
        config: Config of the run.
    """
    found = [validate(policy, config, price - usual) for price, policy in policies.items()]
    return {name: _mean([row[name] for row in found]) for name in found[0]}


def _mean(values: Sequence[float | None]) -> float | None:
    defined = [value for value in values if value is not None]
    return float(np.mean(defined)) if defined else None


def best_of(found: Sequence[Validated], config: TrainConfig) -> Validated:
    """Return the best of a run's validations; the first one if several are equally good."""
    limit = config.lagrangian.limit if config.lagrangian else None
    return max(found, key=lambda each: selection_key(each, limit))


def selection_key(found: Validated, limit: float | None) -> tuple[float, float]:
    """Return the selection key of a validation: constraint satisfaction first, then return.

    Args:
        found: Result of ``validate``.
        limit: Limit of the mean cost of an episode; None without a limit.
    """
    excess = 0.0 if limit is None else max(cast(float, found["cost"]) - limit, 0.0)
    return -excess, cast(float, found["return"])
