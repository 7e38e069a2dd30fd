"""Keep a study of how PPO learns: ``python docs/keep_learning.py learning=DIR``.

Each of ``NAMES`` is a study with ``configs/study_NAME.yaml``, ``learning`` one with
``configs/study_crossing.yaml``. Writes the record of that name into ``benchmarks/`` and the
learning curves as a picture.
"""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path
from typing import Any

import pandas as pd
from learning_page import DOORWAY, curves_of

from hazbot_gym.paper.plot_style import BLUE, INK, SOFT, legend, new, svg
from hazbot_gym.study import store
from hazbot_gym.study.candidates import folder_of
from hazbot_gym.study.config import StudyConfig
from hazbot_gym.study.headline import POOLED, TEST, scenarios_of
from hazbot_gym.study.report import page
from hazbot_gym.study.results import SetResults
from hazbot_gym.study.summary import summarise_set
from hazbot_gym.training.run_folder import RESULT
from hazbot_gym.utils.files import read_json, write_json, write_text

ROOT = Path(__file__).parents[1]
RECORDS, IMAGES = ROOT / "benchmarks", ROOT / "docs" / "images"
NAMES = (
    "learning",
    "ablations",
    "ablations_more",
    "from_nothing",
    "faster",
    "inspection",
    "longer",
    "tqc_crossq",
)
METRICS = ("return", "delay_s", "discomfort_s", "personal_m", "arrived", "contacts_per_km")
COLUMNS, LEAST_HEIGHT_IN = 3, 3.2
TITLE_WIDTH = 30  # characters
EXPERT = "fuzzy_expert"
IN_ENV = "return/"  # before an environment, in a validation
SECONDS = ("training_seconds", "imitation_seconds", "specialists_seconds")  # of a run


def kept(folder: Path) -> dict[str, Any]:
    """Return what the page needs of a study of one scenario set, or of several together."""
    study = page.read(folder)
    sets = study.summary["sets"]
    rows = store.read_episodes(folder / store.EPISODES)
    found = next(sets[name] for name in (POOLED, TEST, *sets) if name in sets)
    return {
        "reference": study.summary["reference"],
        "episodes": scenarios_of(found),
        "commit": study.manifest["commit"],
        "machine": study.manifest["machine"],
        "policies": {
            policy: {name: block["metrics"][name] for name in METRICS}
            | {"return_gain": block["return_gain"]}
            for policy, block in found.items()
        },
        "gains": {
            rule: {
                learner.name: compared[learner.name]["return_gain"]
                for learner in study.config.learners
            }
            for rule, compared in _compared(study.config, rows).items()
        },
        "runs": runs(study.config, rows, folder),
    }


def runs(study: StudyConfig, rows: pd.DataFrame, folder: Path) -> dict[str, Any]:
    """Return time, learning curve and mean return in some episodes of each training run."""
    means = rows.groupby(["policy", "training_seed"])["return"].mean()
    return {
        learner.name: [
            _run(folder_of(learner, k, folder)) | {"return": float(means[learner.name, k])}
            for k in range(learner.seeds)
        ]
        for learner in study.learners
    }


def _compared(study: StudyConfig, rows: pd.DataFrame) -> dict[str, SetResults]:
    """Return the results of all policies together, with each rule in turn as the reference."""
    return {
        rule: summarise_set(rows, study.model_copy(update={"reference": rule}))
        for rule in study.policies
    }


def _run(folder: Path) -> dict[str, Any]:
    """Return time and learning curves of a run: returns on its validation scenarios."""
    result = read_json(folder / RESULT)
    found = result["validations"]
    return {
        "training_seconds": sum(result.get(name, 0.0) for name in SECONDS),
        "steps": [each["step"] for each in found],
        "returns": [each["return"] for each in found],
        "delays_s": [each["delay_s"] for each in found],
        "by_env": {
            name.removeprefix(IN_ENV): [each[name] for each in found]
            for name in found[0]
            if name.startswith(IN_ENV)
        },
    }


def curves(
    record: dict[str, Any],
    *,
    unit: str = "million actions",
    scale: float = 1e6,
    least: float | None = None,
) -> str:
    """Draw the learning curves of all seeds, a panel for each learner, rules as lines.

    Steps are divided by ``scale`` to be in the unit; returns below ``least`` are cut off.
    """
    runs, policies = record["runs"], record["policies"]
    rules = {name: each["return"]["mean"] for name, each in policies.items() if name not in runs}
    best = max(rules, key=lambda name: rules[name])
    columns = min(COLUMNS, len(runs))
    rows = -(-len(runs) // columns)
    height_in = max(1.85 * rows + 0.4, LEAST_HEIGHT_IN)
    figure, axes = new(height_in, rows, columns, sharex=True, sharey=True, squeeze=False)
    for axis in axes.flat[len(runs) :]:
        axis.set_visible(False)
    for axis, (name, seeds) in zip(axes.flat, runs.items(), strict=False):
        axis.set_title(textwrap.fill(name, TITLE_WIDTH), fontsize=9, color=INK)
        axis.axhline(rules[EXPERT], color=SOFT, linewidth=1.0, linestyle=":")
        axis.axhline(rules[best], color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
        for k, run in enumerate(seeds):
            label = "validation scenarios, one line a seed" if k == 0 else None
            done = [step / scale for step in run["steps"]]
            axis.plot(done, run["returns"], "o-", color=BLUE, linewidth=1.1, ms=3, label=label)
    for axis in axes.flat[max(len(runs) - columns, 0) : len(runs)]:  # the lowest of each column
        axis.tick_params(labelbottom=True)
    axes[0, 0].set_ylim(bottom=least)
    figure.supxlabel(unit, fontsize=9)
    figure.supylabel("return", fontsize=9)
    axes[0, 0].lines[0].set_label(EXPERT)
    axes[0, 0].lines[1].set_label(best)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    legend(figure, handles=handles, labels=labels, loc="outside upper center", ncols=3)
    return svg(figure)


def places(record: dict[str, Any]) -> str:
    """Draw the learning curves of all seeds: in all environments, in a doorway, in the others."""
    (runs,) = record["runs"].values()
    figure, axes = new(LEAST_HEIGHT_IN, 1, 3, sharex=True)
    titles = ("all environments", DOORWAY, "the others")
    for axis, title, curve in zip(
        axes, titles, zip(*map(curves_of, runs), strict=True), strict=True
    ):
        axis.set_title(title, fontsize=9, color=INK)
        for run, returns in zip(runs, curve, strict=True):
            done = [step / 1e6 for step in run["steps"]]
            axis.plot(done, returns, "o-", color=BLUE, linewidth=1.1, ms=3)
    figure.supxlabel("million actions", fontsize=9)
    figure.supylabel("return on validation scenarios", fontsize=9)
    return svg(figure)


if __name__ == "__main__":
    name, given = sys.argv[1].split("=", 1)
    if name not in NAMES:
        raise SystemExit(f"{name}: allowed are {', '.join(NAMES)}")
    record = kept(Path(given))
    write_text(IMAGES / f"{name}.svg", places(record) if name == "longer" else curves(record))
    write_json(RECORDS / f"{name}.json", record)
