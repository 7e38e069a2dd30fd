"""Keep the study of every algorithm: ``python docs/keep_full.py DIR``.

DIR is a study with ``configs/study_full.yaml``. Writes ``benchmarks/full.json`` and the learning
curves of all seeds as a picture.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from full_record import FULL, REAL
from keep_learning import IMAGES, curves, runs
from keep_study import block_of

from hazbot_gym.evaluation.prices import RETURNS
from hazbot_gym.study import costs, store
from hazbot_gym.study.answer import learned
from hazbot_gym.study.candidates import TUNED
from hazbot_gym.study.headline import headline
from hazbot_gym.study.report import page
from hazbot_gym.study.results import Summary, mean_return
from hazbot_gym.study.summary import summarise_set
from hazbot_gym.utils.files import read_json, write_json, write_text

LEAST = 250.0  # return shown in the learning curves
METRICS = (
    *("return", "delay_s", "discomfort_s", "personal_m", "intimate_m", "person_delay_s"),
    *("contacts_per_km", "contact_person_caused", "arrived", *RETURNS),
)


def kept(folder: Path) -> dict[str, Any]:
    """Return what the page needs of the study in a folder."""
    study = page.read(folder)
    name, sets, found = headline(study.summary)
    rows = study.rows[study.rows["scenario_set"].isin(sets)]
    trained = set(learned(study.config))
    rules = [each for each in found if each not in trained]
    best = max(rules, key=lambda rule: mean_return(found[rule]))
    compared = summarise_set(rows, study.config.model_copy(update={"reference": best}))
    return {
        "commit": study.manifest["commit"],
        "machine": study.manifest["machine"],
        "reference": study.summary["reference"],
        "headline": name,
        "rules": rules,
        "best_rule": best,
        "over_best_rule": {policy: compared[policy]["return_gain"] for policy in compared},
        "sets": {
            each: block_of(block, METRICS if each in (name, *REAL) else ("return",))
            for each, block in study.summary["sets"].items()
            if each in (name, *sets, *REAL)
        },
        "oracle": oracle_of(study.summary),
        "tuned": {
            family: read_json(folder / TUNED / f"{family}.json")["best"]["policy"]
            for family in study.config.tuned
        },
        "sessions": costs.read(folder / store.COSTS).sessions,
        "runs": runs(study.config, rows, folder),
    }


def oracle_of(summary: Summary) -> dict[str, Any]:
    """Return the share of the exact optimum's gain over the best constant speed, by policy."""
    exact = summary.get("oracle", {}).get("exact")
    if exact is None:
        return {}
    return {policy: regret["normalised"] for policy, regret in exact["policies"].items()}


def drawn(record: dict[str, Any]) -> dict[str, Any]:
    """Return runs and rules as ``curves`` draws them, with seconds of training for steps."""
    found = record["sets"][record["headline"]]
    timed = {
        learner: [
            run
            | {
                "steps": [
                    run["training_seconds"] * step / run["steps"][-1] for step in run["steps"]
                ]
            }
            for run in seeds
        ]
        for learner, seeds in record["runs"].items()
    }
    return {"runs": timed, "policies": {name: found[name]["metrics"] for name in record["rules"]}}


if __name__ == "__main__":
    record = kept(Path(sys.argv[1]))
    write_json(FULL, record)
    shown = curves(drawn(record), unit="seconds of training", scale=1.0, least=LEAST)
    write_text(IMAGES / "full.svg", shown)
