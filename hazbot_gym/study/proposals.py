"""Proposals of values to try: Optuna's tree-structured Parzen estimator (Bergstra et al. 2011).

A proposal is a pure function of the trials before it and a seed, so that a killed search resumes
with the same results.
"""

from __future__ import annotations

import threading
import warnings
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from hazbot_gym.errors import MissingExtra

try:
    import optuna
    from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution
except ImportError as error:
    raise MissingExtra(error.name or "optuna", "study") from error

_ASKING = threading.Lock()  # searches run in threads, and warning filters are of the process


Distribution = BaseDistribution
Scalar = str | float | int | bool | None


def interval(low: float, high: float, *, is_log: bool = False) -> Distribution:
    """Return a uniform or log-uniform distribution of a number."""
    return FloatDistribution(low, high, log=is_log)


def choice(values: Sequence[Scalar]) -> Distribution:
    """Return a distribution over a list of values."""
    return CategoricalDistribution(values)


class Trial(NamedTuple):
    """Values that were tried, and what they were worth."""

    values: Mapping[str, object]
    worth: float


def propose(
    space: Mapping[str, Distribution],
    trials: Sequence[Trial],
    seed: int,
    *,
    first_at_random: int,
) -> dict[str, object]:
    """Return the values of the next trial; numbers have three significant digits.

    Args:
        space: Distribution of each value.
        trials: Trials so far.
        seed: Seed of the search.
        first_at_random: Number of random trials before the estimator starts.
    """
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with _ASKING, warnings.catch_warnings():  # optuna < 5 warns about multivariate sampling
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        sampler = optuna.samplers.TPESampler(
            n_startup_trials=first_at_random, multivariate=True, seed=seed + 1000 * len(trials)
        )
    study = optuna.create_study(direction="maximize", sampler=sampler)
    study.add_trials(
        [
            optuna.trial.create_trial(
                params=dict(trial.values), distributions=dict(space), value=trial.worth
            )
            for trial in trials
        ]
    )
    chosen = study.ask(dict(space)).params
    return {
        name: float(f"{chosen[name]:.3g}") if isinstance(each, FloatDistribution) else chosen[name]
        for name, each in space.items()
    }
