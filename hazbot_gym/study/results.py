"""Types of a study's ``summary.json``; None stands for numbers that are not finite."""

from __future__ import annotations

from typing import NotRequired, TypedDict


class Interval(TypedDict):
    """A mean with its interval."""

    mean: float | None
    low: float | None
    high: float | None


class Difference(Interval):
    """A paired difference from the reference, with its p-values."""

    p: float | None
    p_holm: NotRequired[float | None]  # corrected
    less: float | None  # probability of being less than the reference


class Gain(Interval):
    """A gain in return over the reference."""

    probability: Interval  # of an improvement


Metrics = dict[str, Interval]


class PolicyResult(TypedDict):
    """Results of a policy in a set."""

    episodes: int
    training_seeds: int
    metrics: Metrics
    tails: Metrics
    iqm: Interval
    return_gain: Gain
    difference: dict[str, Difference]
    dominated_by: NotRequired[list[str] | None]
    clearance_quantiles_m: NotRequired[list[float | None]]


class OneResult(TypedDict):
    """Results of a policy in a set, without a comparison."""

    episodes: int
    training_seeds: int
    metrics: Metrics


SetResults = dict[str, PolicyResult]  # by policy


class HeadlineEntry(TypedDict):
    """Headline of a study; see ``headline.py``."""

    name: str
    sets: list[str]
    zero_is_below_one_in: int


class FrontPoint(TypedDict):
    """A policy of a family, with its mean on both axes."""

    policy: str
    delay_s: Interval
    discomfort_s: Interval
    on_front: bool


class Family(TypedDict):
    """Points of a family and their hypervolume; see ``front_summary.py``."""

    points: list[FrontPoint]
    hypervolume: Interval
    difference: Interval  # from the first family
    behind: Interval  # difference from the largest; a tie if the interval contains 0


class OracleComparison(TypedDict):
    """Regret of every policy; see ``evaluation/statistics/regret.py``."""

    episodes: int
    constant: str | None
    best: dict[str, float | None]
    policies: dict[str, dict[str, Interval]]


class Summary(TypedDict):
    """Results of a study."""

    study: str
    ssm_profile: str
    confidence: float
    reference: str
    sets: dict[str, SetResults]
    headline: HeadlineEntry
    default_policies: list[str]
    fronts: NotRequired[dict[str, dict[str, Family]]]
    oracle: NotRequired[dict[str, OracleComparison]]


def mean_return(result: PolicyResult) -> float:
    """Return the mean return of a policy in a set, which every episode defines."""
    mean = result["metrics"]["return"]["mean"]
    if mean is None:
        raise ValueError("a summary without a mean return")
    return mean
