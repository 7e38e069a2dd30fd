"""Rows to results: means with intervals for every policy in every set, and paired differences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.metrics import Row
from hazbot_gym.study.statistics import (
    Estimate,
    bootstrap_mean,
    paired_difference,
    scenario_draws,
    wilson,
)

if TYPE_CHECKING:
    import pandas as pd

# Shares of episodes, which get Wilson's interval; all other metrics are means with the bootstrap's.
RATES = (
    "arrived",
    "timeout",
    "contact_robot_caused",
    "contact_person_caused",
    "contact_wall",
)
# What `hazbot eval --json` reports, in this order; the table shows the same.
HEADLINE = (
    "arrived",
    "timeout",
    "contact_robot_caused",
    "contact_person_caused",
    "ssm_violation",
    "kinetic_intrusion_m2",
    "time_ratio",
    "rms_jerk_mps3",
    "return",
)
# Declared before any run: what policies are compared by.
COMPARED = (
    "contact_robot_caused",
    "ssm_violation",
    "kinetic_intrusion_m2",
    "time_ratio",
    "rms_jerk_mps3",
)
LABELS = ("episode", "seed")  # numbers that name an episode and measure nothing
POOLED = "all sets"
Summary = dict[str, Any]


def summarise(rows: pd.DataFrame, study: StudyConfig) -> Summary:
    """Return the study's results as plain values, the same to the last digit for the same rows.

    Raises:
        InvalidInput: rows measured with different thresholds, policies that did not meet the same
            scenarios, or scenarios that are not as the bank has them.
    """
    _check(rows)
    names = [scenarios.name for scenarios in study.all_sets]
    sets = {name: rows[rows["scenario_set"] == name] for name in names}
    blocks = sets if len(sets) == 1 else {**sets, POOLED: rows}
    return {
        "study": study.identity(),
        "ssm_profile": study.ssm.profile(),
        "confidence": study.confidence,
        "reference": study.reference_policy,
        "sets": {name: summarise_set(block, study) for name, block in blocks.items()},
    }


def summarise_one(rows: Sequence[Row], *, seed: int) -> dict[str, Any]:
    """Return the results of one policy in one set, as ``summarise`` gives them, from bare rows."""
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    draws = scenario_draws(columns["scenario_set"], np.random.default_rng(seed))
    return {"episodes": len(rows), "metrics": _estimates(columns, draws, 0.95)}


def means(rows: Sequence[Row]) -> dict[str, float | None]:
    """Return the mean of each headline metric over rows, None where it is nowhere defined."""
    columns = {name: np.array([row[name] for row in rows], dtype=float) for name in HEADLINE}
    return {
        name: float(column[np.isfinite(column)].mean()) if np.isfinite(column).any() else None
        for name, column in columns.items()
    }


def summarise_set(rows: pd.DataFrame, study: StudyConfig) -> Summary:
    """Summarise every policy in a set (or in all sets together, each resampled by itself)."""
    grouped = {policy: group for policy, group in rows.groupby("policy", sort=False)}
    reference = grouped[study.reference_policy]
    # From the seed alone, and the same for every policy: what is paired stays paired.
    rng = np.random.default_rng(study.seed)
    draws = scenario_draws(reference["scenario_set"], rng, resamples=study.resamples)
    return {
        policy: {
            "episodes": len(grouped[policy]),
            "metrics": _estimates(grouped[policy], draws, study.confidence),
            "difference": {
                name: _plain(
                    paired_difference(
                        grouped[policy][name], reference[name], draws, confidence=study.confidence
                    )
                )
                for name in COMPARED
            },
        }
        for policy in study.policies
    }


def _estimates(
    columns: Mapping[str, npt.NDArray[Any]] | pd.DataFrame, draws: Floats, confidence: float
) -> dict[str, dict[str, float | None]]:
    """Return the estimate of every column that is a metric, and leave out the labels."""
    estimates = {}
    for name in columns:
        values = np.asarray(columns[name])
        if name in RATES:
            estimates[name] = wilson(float(values.sum()), len(values), confidence=confidence)
        elif values.dtype.kind in "if" and name not in LABELS:
            estimates[name] = bootstrap_mean(values, draws, confidence=confidence)
    return {name: _plain(estimate) for name, estimate in estimates.items()}


def _plain(estimate: Estimate) -> dict[str, float | None]:
    """Return an estimate as JSON values, rounded so that no processor's last digit shows."""
    return {
        name: float(f"{value:.9g}") if math.isfinite(value) else None
        for name, value in estimate._asdict().items()
    }


def _check(rows: pd.DataFrame) -> None:
    from hazbot_gym.study import bank  # reads parquet, which one policy's results can do without

    bank.check(rows)
    profiles = sorted(set(rows["ssm_profile"]))
    if len(profiles) > 1:
        raise InvalidInput(
            f"ssm: rows measured with different thresholds ({', '.join(profiles)}) do not mix"
        )
    met = rows.groupby(["scenario_set", "episode"])["scenario_key"].nunique()
    if (met > 1).any():
        name, episode = met.index[met > 1][0]
        raise InvalidInput(
            f"episode {episode} of {name!r} was not the same scenario for all policies"
        )
