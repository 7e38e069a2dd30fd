"""Pareto dominance of policies, which trade delay against discomfort of people.

A policy is dominated if another policy is better on both axes with disjoint intervals. This test is
conservative: overlapping intervals can still hide a difference between paired episodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

AXES = ("delay_s", "discomfort_s")  # both are minimized

Metrics = Mapping[str, Mapping[str, float | None]]


def dominated(policies: Mapping[str, Mapping[str, Any]]) -> dict[str, list[str]]:
    """Return the dominating policies of each policy; an empty list if it is Pareto-optimal.

    Args:
        policies: a set of a study's summary: each policy's ``metrics`` with mean, low and high.
    """
    metrics = {policy: result["metrics"] for policy, result in policies.items()}
    return {
        policy: [other for other in metrics if dominates(metrics[other], metrics[policy])]
        for policy in metrics
    }


def standing(policies: Mapping[str, Mapping[str, Any]]) -> dict[str, list[str] | None]:
    """Return ``dominated`` of a set; None for all if no policy has an interval.

    A set of a single scenario has none, and says nothing of dominance.
    """
    is_known = any(
        result["metrics"][axis]["low"] is not None for result in policies.values() for axis in AXES
    )
    return {policy: by if is_known else None for policy, by in dominated(policies).items()}


def dominates(ours: Metrics, theirs: Metrics, axes: tuple[str, str] = AXES) -> bool:
    """Return True if ours is better on both axes, with disjoint intervals."""
    return all(_is_less(ours[axis]["high"], theirs[axis]["low"]) for axis in axes)


def _is_less(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and a < b
