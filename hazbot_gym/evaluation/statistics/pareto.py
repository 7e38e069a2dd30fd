"""Who is beaten outright: policies trade time against intrusion, so single numbers rank nobody.

A policy is dominated if another one is better on both axes beyond their intervals. That is a
cautious test: intervals that overlap can still hide a difference between paired episodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

AXES = ("time_ratio", "kinetic_intrusion_m2")  # of both, less is better

Metrics = Mapping[str, Mapping[str, float | None]]


def dominated(policies: Mapping[str, Mapping[str, Any]]) -> dict[str, list[str]]:
    """Return by whom each policy is dominated, nobody's name for most.

    Args:
        policies: a set of a study's summary: each policy's ``metrics`` with mean, low and high.
    """
    metrics = {policy: result["metrics"] for policy, result in policies.items()}
    return {
        policy: [other for other in metrics if dominates(metrics[other], metrics[policy])]
        for policy in metrics
    }


def dominates(ours: Metrics, theirs: Metrics) -> bool:
    """Tell whether we are better on both axes, with intervals that do not touch."""
    return all(_is_less(ours[axis]["high"], theirs[axis]["low"]) for axis in AXES)


def _is_less(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and a < b
