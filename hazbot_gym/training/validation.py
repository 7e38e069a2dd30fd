"""How good a policy is while it is trained: metrics over scenarios that no test uses."""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.core.ssm import SsmThresholds
from hazbot_gym.evaluation import batch_rollout, rollout
from hazbot_gym.evaluation.metrics import means, measure
from hazbot_gym.training.config import TrainConfig, shares

ROOT = 0  # of the seeds: all runs are validated on the same scenarios


def validate(policy: Any, config: TrainConfig) -> dict[str, float | None]:
    """Return the mean of each headline metric, and of the cost, over a run's validation scenarios.

    The name of a scenario set enters its seeds, and no set of a study has a name like these.

    Args:
        policy: With ``predict``, deterministic.
        config: Of the run.
    """
    rows = []
    episodes = shares(config.validation.episodes, len(config.env))
    for env, each, count in zip(config.env, config.environments(), episodes, strict=True):
        seeds = [rollout.episode_seed(ROOT, f"validation of {env}", i) for i in range(count)]
        limit, threads = each.max_episode_steps, config.threads
        runs = batch_rollout.run_episodes(each, policy, seeds, limit=limit, threads=threads)
        rows += [measure(episode, SsmThresholds()) for episode, _ in runs] if seeds else []
    return {**means(rows), "cost": float(np.mean([row["cost"] for row in rows]))}


def merit(found: dict[str, Any], limit: float | None) -> tuple[float, float]:
    """Return what validations are ranked by: the larger return, and before it what keeps a limit.

    Args:
        found: What ``validate`` returned.
        limit: On the mean cost of an episode; None for none.
    """
    excess = 0.0 if limit is None else max(found["cost"] - limit, 0.0)
    return -excess, found["return"]
