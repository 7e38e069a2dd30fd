"""Keep a study for the documentation: ``python docs/keep_study.py shipped=DIR``.

``shipped`` is the study that trained the shipped policy (``configs/study_from_rules.yaml``),
``shield`` that of its contacts without and with a shield (``configs/study_shield.yaml``),
``shield_test`` the same in the test scenarios (``configs/study_shield_test.yaml``), ``many`` that
in many scenarios (``configs/study_many.yaml``). A part not given stays as it is.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from study_report import LEARNED, STUDY, TIERS

from hazbot_gym.evaluation.metrics import HEADLINE
from hazbot_gym.evaluation.prices import RETURNS
from hazbot_gym.study import store
from hazbot_gym.study.headline import TEST
from hazbot_gym.study.report import page
from hazbot_gym.study.results import SetResults, Summary
from hazbot_gym.study.summary import summarise_set
from hazbot_gym.utils.files import read_json, write_json
from hazbot_gym.utils.json_object import JsonObject

EXPERT = "fuzzy_expert"
KEPT = dict.fromkeys((*HEADLINE, *RETURNS, "contact_robot_caused", "ssm_violation"))


def record_of(summary: Summary) -> JsonObject:
    """Return what the pages need of a study's summary."""
    return {
        "study": summary["study"],
        "reference": summary["reference"],
        "sets": {
            name: block_of(policies, tuple(KEPT)) for name, policies in summary["sets"].items()
        },
    }


def block_of(found: SetResults, metrics: Sequence[str]) -> JsonObject:
    """Return some metrics of all policies in a set, and their gains over the reference."""
    return {
        policy: {
            "episodes": each["episodes"],
            "training_seeds": each["training_seeds"],
            "metrics": {metric: each["metrics"][metric] for metric in metrics},
            "return_gain": each["return_gain"],
        }
        for policy, each in found.items()
    }


def shipped(folder: Path) -> JsonObject:
    """Return the record of the study of the shipped policy.

    With the learner's gain over the expert, too, and the mean return of each of its seeds.
    """
    study, rows = page.read(folder), store.read_episodes(folder / store.EPISODES)
    config = study.config.model_copy(update={"reference": EXPERT})
    returns = rows[rows["policy"] == LEARNED].groupby("training_seed")["return"].mean()
    return record_of(study.summary) | {
        "over_expert": summarise_set(rows, config)[LEARNED]["return_gain"],
        "returns": returns.tolist(),
    }


def shield(folder: Path) -> JsonObject:
    """Return the record of the study of the shield: the sets of each tier together."""
    record = record_of(page.read(folder).summary)
    return record | {"sets": {tier: record["sets"][tier] for tier in TIERS}}


def many(folder: Path) -> JsonObject:
    """Return the record of the study with many scenarios: those of all environments together."""
    record = record_of(page.read(folder).summary)
    return record | {"sets": {"tracks": record["sets"]["tracks"]}}


def shield_test(folder: Path) -> JsonObject:
    """Return the record of the shield in the test scenarios of all environments together."""
    record = record_of(page.read(folder).summary)
    return record | {"sets": {TEST: record["sets"][TEST]}}


PARTS = {"shipped": shipped, "shield": shield, "shield_test": shield_test, "many": many}

if __name__ == "__main__":
    folders = dict(argument.split("=", 1) for argument in sys.argv[1:])
    record = read_json(STUDY)
    record |= {part: PARTS[part](Path(folder)) for part, folder in folders.items()}
    write_json(STUDY, record)
