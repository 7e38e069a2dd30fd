"""Study summary: means with intervals for every policy in every set, and paired differences."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, TypedDict, cast

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import InvalidInput
from hazbot_gym.evaluation.encounters import Row
from hazbot_gym.evaluation.metrics import CONTACTS, DRIVEN, PER_KM
from hazbot_gym.evaluation.prices import RETURNS, at_price
from hazbot_gym.evaluation.statistics.crossed_bootstrap import (
    CrossedDraws,
    crossed_draws,
    crossed_estimate,
    crossed_estimates,
    crossed_means,
    each_once,
)
from hazbot_gym.evaluation.statistics.intervals import (
    Estimate,
    ratio,
    wilson,
    within,
)
from hazbot_gym.evaluation.statistics.multiple_comparisons import holm
from hazbot_gym.evaluation.statistics.paired_scores import differences, improvements, pair_draws
from hazbot_gym.evaluation.statistics.pareto import standing
from hazbot_gym.evaluation.statistics.regret import regrets
from hazbot_gym.evaluation.statistics.robust_means import (
    conditional_value_at_risk,
    interquartile_mean,
)
from hazbot_gym.evaluation.statistics.student import student_interval, student_p_value
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.default_policies import default_policies
from hazbot_gym.study.front_summary import summarise_fronts
from hazbot_gym.study.headline import headline_sets, pooled_sets, scenarios_of
from hazbot_gym.study.results import (
    Difference,
    Family,
    Gain,
    HeadlineEntry,
    Interval,
    Metrics,
    OneResult,
    OracleComparison,
    PolicyResult,
    SetResults,
    Summary,
)

if TYPE_CHECKING:
    import pandas as pd

# Shares of episodes, with Wilson's interval; all other metrics are means with bootstrap intervals.
RATES = (
    "arrived",
    "timeout",
    "contact_robot_caused",
    "contact_person_caused",
    "contact_wall",
)
# Compared metrics, declared before any run.
COMPARED = (
    "delay_s",
    "personal_m",
    "intimate_m",
    "person_delay_s",
    "discomfort_s",
    "contact_robot_caused",
)
LABELS = ("episode", "seed", "training_seed")  # numeric labels of an episode, not metrics
# Tails: the mean of the worst 5 %, and the bad end of the metric.
TAILS: dict[str, Literal["low", "high"]] = {
    "clearance_min_m": "low",
    "ttc_min_s": "low",
    "discomfort_s": "high",
    "delay_s": "high",
}
WORST, MOST_RESAMPLES_OF_TAILS = 0.05, 1000  # each resample of a tail weights every run
LEVELS = np.linspace(0.0, 1.0, 101)  # of the quantiles of clearance


class _IntervalOptions(TypedDict):
    """Options of the bootstrap intervals."""

    resamples: int
    confidence: float
    seed: int


def summarise(rows: pd.DataFrame, study: StudyConfig, best: pd.DataFrame | None = None) -> Summary:
    """Return the study's results as plain values, bit-identical for equal rows.

    Args:
        rows: of all episodes.
        study: the study.
        best: rows of the oracle, if the study has one.

    Raises:
        InvalidInput: rows measured with different thresholds, policies with different scenarios, or
            scenarios that differ from the bank's.
    """
    _check(rows)
    parts = {each.name: [each.name] for each in study.all_sets} | pooled_sets(study)
    blocks = {name: rows[rows["scenario_set"].isin(sets)] for name, sets in parts.items()}
    sets = {name: summarise_set(block, study) for name, block in blocks.items()}
    entry = _headline(sets, study)
    summary: Summary = {
        "study": study.identity(),
        "ssm_profile": study.ssm.profile(),
        "confidence": study.confidence,
        "reference": study.reference_policy,
        "sets": sets,
        "headline": entry,
        "default_policies": default_policies(sets[entry["name"]], study),
    }
    interval = _IntervalOptions(
        resamples=study.resamples, confidence=study.confidence, seed=study.seed
    )
    if study.fronts is not None:
        blocks = _blocks(rows, [each.name for each in study.sets_named(study.fronts.sets)])
        summary["fronts"] = {
            name: cast(
                dict[str, Family], _all_plain(summarise_fronts(block, study.fronts, **interval))
            )
            for name, block in blocks.items()
        }
    if best is not None:
        summary["oracle"] = {
            name: cast(
                OracleComparison,
                _all_plain(regrets(rows, block, study.names, **interval)),
            )
            for name, block in _by_exactness(best).items()
        }
    return summary


def _headline(sets: dict[str, SetResults], study: StudyConfig) -> HeadlineEntry:
    """Return the headline's name and sets, and the n of its rate bound of one in n.

    No event in N scenarios is compatible with a rate of up to ``3 / N`` (95 %; rule of three,
    Hanley and Lippman-Hand 1983).
    """
    name, pooled = headline_sets(study)
    scenarios = scenarios_of(sets[name])
    return {"name": name, "sets": pooled, "zero_is_below_one_in": max(scenarios // 3, 1)}


def _blocks(rows: pd.DataFrame, names: Sequence[str]) -> dict[str, pd.DataFrame]:
    """Return the rows of some sets, the pooled rows first."""
    wanted = rows[rows["scenario_set"].isin(names)]
    each = {name: wanted[wanted["scenario_set"] == name] for name in names}
    return {"together": wanted, **each} if len(names) > 1 else each


def _by_exactness(best: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the oracle's rows: exact ones pooled, searched ones pooled, and by set."""
    kinds = {"exact": best[best["is_exact"] == 1], "searched": best[best["is_exact"] == 0]}
    together = {kind: rows for kind, rows in kinds.items() if rows["scenario_set"].nunique() > 1}
    return together | dict(iter(best.groupby("scenario_set", sort=False)))


def summarise_one(rows: Sequence[Row], *, seed: int) -> OneResult:
    """Return the results of one policy in one set, as in ``summarise``, from plain rows."""
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    (draws,) = crossed_draws(columns["scenario_set"], [1], np.random.default_rng(seed))
    metrics = _estimates(columns, draws, 0.95)
    return {"episodes": len(rows), "training_seeds": 1, "metrics": metrics}


def summarise_set(rows: pd.DataFrame, study: StudyConfig) -> SetResults:
    """Summarise every policy in a set (or in all sets pooled, each resampled separately)."""
    # Scenarios are sorted within each training seed, independent of the order of the shards.
    ordered = rows.sort_values("training_seed", kind="stable")
    grouped = {policy: group for policy, group in ordered.groupby("policy", sort=False)}
    reference = grouped[study.reference_policy]
    # From the seed alone, and equal for every policy, so that pairs are kept.
    rng = np.random.default_rng(study.seed)
    strata = reference["scenario_set"][reference["training_seed"] == 0]
    seeds = [grouped[policy]["training_seed"].nunique() for policy in study.names]
    drawn = crossed_draws(strata, seeds, rng, resamples=study.resamples)
    draws = dict(zip(study.names, drawn, strict=True))
    results = {
        policy: _summarise_policy(
            grouped[policy],
            draws[policy],
            reference,
            pair_draws(draws[policy], draws[study.reference_policy]),
            study.confidence,
        )
        for policy in study.names
    }
    _correct(results, study.reference_policy)
    for policy, by in standing(results).items():
        results[policy]["dominated_by"] = by
    for policy in study.shown_names:
        if "clearance_min_m" in rows:
            results[policy]["clearance_quantiles_m"] = _quantiles(
                grouped[policy]["clearance_min_m"].to_numpy(dtype=float)
            )
    return results


def _quantiles(values: Floats) -> list[float | None]:
    """Return the observed values at ``LEVELS``, to the centimetre; None where infinite.

    An episode without people has an infinite clearance.
    """
    found = np.quantile(values, LEVELS, method="inverted_cdf")
    return [_rounded(round(float(value), 2)) for value in found]


def _summarise_policy(
    rows: pd.DataFrame,
    draws: CrossedDraws,
    reference: pd.DataFrame,
    pairs: CrossedDraws,
    confidence: float,
) -> PolicyResult:
    """Return a policy's results in a set, and its paired differences from the reference."""
    returns = _scores(rows, ["return"])[0]
    middle = crossed_estimate(
        returns, _first_draws(draws), interquartile_mean, confidence=confidence
    )
    return {
        "episodes": len(rows),
        "training_seeds": len(draws.seeds[0]),
        "metrics": _estimates(rows, draws, confidence),
        "tails": _tails(rows, draws, confidence),
        "iqm": _plain(middle),
        "return_gain": _gain(returns, _scores(reference, ["return"])[0], pairs, confidence),
        "difference": _compare(
            _scores(rows, COMPARED), _scores(reference, COMPARED), pairs, confidence
        ),
    }


def _scores(rows: pd.DataFrame, metrics: Sequence[str]) -> Floats:
    """Return a policy's metrics as score matrices, (metrics, training seeds, scenarios)."""
    values = rows[list(metrics)].to_numpy(dtype=float)
    scores: Floats = values.T.reshape(len(metrics), rows["training_seed"].nunique(), -1)
    return scores


def _compare(
    ours: Floats, theirs: Floats, draws: CrossedDraws, confidence: float
) -> dict[str, Difference]:
    """Return paired difference, p-value, and probability of being less for each compared metric.

    Args:
        ours: (metrics, R, N) scores, in the order of ``COMPARED``.
        theirs: (metrics, S, N) scores of the reference.
        draws: of pairs of training seeds.
        confidence: nominal coverage of the intervals.
    """
    pairs = np.stack([differences(*each) for each in zip(ours, theirs, strict=True)])
    wins = np.stack([improvements(-x, -y) for x, y in zip(ours, theirs, strict=True)])
    once, many = crossed_means(pairs, each_once(draws)), crossed_means(pairs, draws)
    less = crossed_means(wins, each_once(draws))
    found: dict[str, Difference] = {}
    for k, name in enumerate(COMPARED):
        compared = float(once[k, 0]), many[k], draws.independent
        over = _plain(student_interval(*compared, confidence=confidence))
        found[name] = {
            "mean": over["mean"],
            "low": over["low"],
            "high": over["high"],
            "p": _rounded(student_p_value(*compared, confidence=confidence)),
            "less": _rounded(float(less[k, 0])),
        }
    return found


def _gain(ours: Floats, theirs: Floats, draws: CrossedDraws, confidence: float) -> Gain:
    """Return the gain in return, and the probability of improvement."""
    both = np.stack([differences(ours, theirs), improvements(ours, theirs)])
    gain, more = crossed_estimates(both, draws, confidence=confidence)
    return {**_plain(gain), "probability": _plain(within(more, 0.0, 1.0))}


def _tails(rows: pd.DataFrame, draws: CrossedDraws, confidence: float) -> Metrics:
    """Return the mean of the worst 5 % of runs (CVaR) of some metrics."""
    return {
        name: _plain(
            crossed_estimate(
                _scores(rows, [name])[0],
                _first_draws(draws),
                conditional_value_at_risk(WORST, worst=worst),
                confidence=confidence,
            )
        )
        for name, worst in TAILS.items()
        if name in rows
    }


def _first_draws(draws: CrossedDraws) -> CrossedDraws:
    few = slice(MOST_RESAMPLES_OF_TAILS)
    return CrossedDraws(draws.seeds[few], draws.scenarios[few])


def _correct(results: SetResults, reference: str) -> None:
    """Add p-values corrected (Holm) over the family: all compared metrics, all other policies."""
    family = [
        each["difference"][name]
        for policy, each in results.items()
        if policy != reference
        for name in COMPARED
    ]
    adjusted = holm([np.nan if each["p"] is None else each["p"] for each in family])
    for each, p in zip(family, adjusted, strict=True):
        each["p_holm"] = _rounded(float(p))


def _estimates(
    columns: Mapping[str, npt.NDArray[np.generic]] | pd.DataFrame,
    draws: CrossedDraws,
    confidence: float,
) -> Metrics:
    """Return the estimate of every metric column, without the labels."""
    values = {name: np.asarray(columns[name]) for name in columns}
    others = RETURNS.keys() - values.keys()
    values |= {name: at_price(values, RETURNS[name]) for name in sorted(others)}
    names = [
        name
        for name, column in values.items()
        if name in RATES or (column.dtype.kind in "if" and name not in LABELS)
    ]
    seeds = draws.seeds.shape[1]
    scores = np.stack([values[name].astype(float).reshape(seeds, -1) for name in names])
    estimates = crossed_estimates(scores, draws, confidence=confidence)
    found = {
        name: _plain(_rate(each, crossed, confidence) if name in RATES else crossed)
        for name, each, crossed in zip(names, scores, estimates, strict=True)
    }
    contacts, driven_m = (scores[names.index(name)] for name in (CONTACTS, DRIVEN))
    return {**found, PER_KM: _plain(_per_km(contacts, driven_m, draws, confidence))}


def _rate(scores: Floats, crossed: Estimate, confidence: float) -> Estimate:
    """Estimate a rate: Wilson's interval over scenarios, at least as wide as the crossed interval.

    Wilson's interval is valid at 0 and 1, where all resamples are equal; n counts scenarios, not
    seeds of a learner. If nothing can be resampled (``crossed_draws``), the interval is NaN.
    """
    if math.isfinite(crossed.mean) and not math.isfinite(crossed.low):
        return crossed
    scenarios = scores.shape[1]
    over = wilson(float(scores.mean()) * scenarios, scenarios, confidence=confidence)
    if len(scores) == 1:
        return over
    wider = Estimate(over.mean, min(over.low, crossed.low), max(over.high, crossed.high))
    return within(wider, 0.0, 1.0)


def _per_km(contacts: Floats, driven_m: Floats, draws: CrossedDraws, confidence: float) -> Estimate:
    """Estimate contacts per kilometre, over all episodes together.

    The interval is at least as wide as that of the share of episodes with a contact (``_rate``) at
    the mean distance, since without contacts all resamples are equal.
    """
    both = np.stack([contacts, driven_m / 1000.0])
    once, many = (ratio(*crossed_means(both, each)) for each in (each_once(draws), draws))
    crossed = student_interval(float(once[0]), many, draws.independent, confidence=confidence)
    if not math.isfinite(crossed.low):
        return crossed
    share = _rate(contacts, crossed_estimate(contacts, draws, confidence=confidence), confidence)
    low, high = (bound / both[1].mean() for bound in share[1:])
    wider = Estimate(crossed.mean, min(low, crossed.low), max(high, crossed.high))
    return within(wider, 0.0)


def _plain(estimate: Estimate) -> Interval:
    """Return an estimate as JSON values, rounded below differences between processors."""
    mean, low, high = map(_rounded, estimate)
    return {"mean": mean, "low": low, "high": high}


def _all_plain(content: object) -> object:
    """Return nested results with every estimate and number as JSON values."""
    if isinstance(content, Estimate):
        return _plain(content)
    if isinstance(content, Mapping):
        return {name: _all_plain(value) for name, value in content.items()}
    if isinstance(content, list):
        return [_all_plain(value) for value in content]
    return _rounded(content) if isinstance(content, float) else content


def _rounded(value: float) -> float | None:
    return float(f"{value:.9g}") if math.isfinite(value) else None


def _check(rows: pd.DataFrame) -> None:
    from hazbot_gym.study import scenario_bank

    scenario_bank.check(rows)
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
