"""What is kept of full studies for the documentation: a small record of large summaries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hazbot_gym.evaluation.metrics import HEADLINE
from hazbot_gym.evaluation.prices import RETURNS
from hazbot_gym.evaluation.statistics.pareto import AXES
from hazbot_gym.study.headline import TEST, groups
from hazbot_gym.study.summary import COMPARED

Record = dict[str, Any]

TOGETHER, EXACTNESS = "together", ("exact", "searched")  # what is pooled of fronts and oracle
TIERS = ("tracks", "sonar")  # of the study of the shield
SHARES = ("normalised",)
RATES = ("arrived", "contact_robot_caused", "contact_person_caused")
KEPT = tuple(dict.fromkeys((*RATES, *HEADLINE, *RETURNS, "ssm_violation")))
# Titles of the axes of fronts. A record of a study before nearness became discomfort has the old
# ones, and is shown with them until the study is run again.
AXIS_TITLES = {
    "delay_s": "delay, s",
    "discomfort_s": "discomfort, s",
    "time_ratio": "time ratio",
    "kinetic_intrusion_m2": "kinetic intrusion, m²",
}
OLD_AXES = ("time_ratio", "kinetic_intrusion_m2")


def axes_of(found: Mapping[str, Any]) -> tuple[str, str]:
    """Return the axes on which a study's record compares policies: time and nearness."""
    metrics = next(iter(found["together"][TEST].values()))["metrics"]
    return AXES if AXES[0] in metrics else OLD_AXES


def record_of(study: Record) -> Record:
    """Return what the pages need of one study.

    Args:
        study: ``summary``, ``manifest``, ``sessions``, ``trainings`` and ``tuned`` of a finished
            study, as plain values.
    """
    summary, manifest = study["summary"], study["manifest"]
    names = list(manifest["environments"])  # sets alone, none that are pooled
    shown, learners = study["shown"], [each["name"] for each in study["trainings"]]
    return {
        "study": summary["study"],
        "commit": manifest["commit"],
        "machine": manifest["machine"],
        "confidence_percent": 100.0 * summary["confidence"],
        "reference": summary["reference"],
        "policies": study["policies"],
        "shown": shown,
        "learners": learners,
        "sessions": study["sessions"],
        "trainings": study["trainings"],
        "tuned": study["tuned"],
        "together": {
            name: {
                policy: _kept(found, is_full=name == TEST)
                for policy, found in summary["sets"][name].items()
                if name == TEST or policy in (*shown, *learners)
            }
            for name in groups(names)
        },
        "sets": {
            name: {policy: _kept(summary["sets"][name][policy]) for policy in shown}
            for name in names
            if name.startswith(f"{TEST}/")
        },
        "fronts": {
            name: block for name, block in summary.get("fronts", {}).items() if name == TOGETHER
        },
        "oracle": {
            name: _with_percents(block)
            for name, block in summary.get("oracle", {}).items()
            if name in EXACTNESS
        },
    }


def small_record_of(summary: Mapping[str, Any]) -> Record:
    """Return what the pages need of a study in which nobody is tuned or trained."""
    return {
        "study": summary["study"],
        "reference": summary["reference"],
        "sets": {
            name: {
                policy: _kept(found) | {"return_gain": found["return_gain"]}
                for policy, found in policies.items()
            }
            for name, policies in summary["sets"].items()
        },
    }


def _kept(found: Mapping[str, Any], *, is_full: bool = False) -> Record:
    kept: Record = {
        "episodes": found["episodes"],
        "training_seeds": found["training_seeds"],
        "metrics": {name: found["metrics"][name] for name in KEPT},
        "percent": {name: _percent(found["metrics"][name]) for name in (*RATES, "ssm_violation")},
    }
    if is_full:
        kept |= {name: found[name] for name in ("tails", "return_gain")}
        kept["difference"] = {name: found["difference"][name] for name in COMPARED}
    return kept


def _with_percents(block: Mapping[str, Any]) -> Record:
    """Return a block of the oracle with its shares in percent."""
    return {
        **block,
        "policies": {
            policy: {
                field: _percent(estimate) if field in SHARES else estimate
                for field, estimate in found.items()
            }
            for policy, found in block["policies"].items()
        },
    }


def _percent(estimate: Mapping[str, float | None]) -> dict[str, float | None]:
    return {name: None if value is None else 100.0 * value for name, value in estimate.items()}
