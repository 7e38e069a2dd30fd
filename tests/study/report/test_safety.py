"""A report of somebody else's folder: nothing that its files name is imported, loaded or run."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from hazbot_gym.study import store
from hazbot_gym.study.report import page as report
from hazbot_gym.utils import files
from tests.refusals import refused

MODULE, PICKLE = "evil:attribute", "learned:path=e.zip,allow_pickle=true"
MARKUP = "constant:</script><img src=x onerror=alert(1)><b>bold</b>"
PEOPLE = ("real people, replay", "real people, seeded")  # the names of sets from tracks
POLICIES = {"stop_on_sight": MODULE, "constant:0.5": PICKLE, "constant:1.0": MARKUP}
SETS = {"E*": PEOPLE[0], "Corridor": PEOPLE[1]}
SCRIPT = """
import json, sys
from hazbot_gym import cli
sys.argv = ["hazbot", "report", sys.argv[1]]
try:
    cli.main()
except SystemExit as end:
    code = end.code
print(json.dumps({"code": code, "modules": sorted(sys.modules)}))
"""


def planted(finished: Path, folder: Path) -> None:
    """Write a folder whose every record names files and modules, under checksums that are right."""
    folder.mkdir()
    manifest = files.read_json(finished / store.MANIFEST)
    config = manifest["config"]
    crossing = next(each for each in config["sets"] if each["name"] == "Crossing")
    crossing["overrides"] = {"place": "gone.yaml"}
    config |= {"policies": ["fuzzy_expert", MODULE, PICKLE], "sets": [crossing], "tracks": "gone"}
    config["learners"] = [{"name": MARKUP, "config": "gone.yaml", "seeds": 1}]
    names = ("fuzzy_expert", *POLICIES.values())
    manifest["candidates"] = {name: [MODULE, PICKLE] for name in names}
    files.write_json(folder / store.MANIFEST, manifest)

    summary = renamed(files.read_json(finished / store.SUMMARY))
    summary["headline"] |= {"name": "Crossing", "sets": ["Crossing"]}
    files.write_json(folder / store.SUMMARY, summary)
    files.write_json(folder / store.COSTS, files.read_json(finished / store.COSTS))
    for name in (store.EPISODES, store.REPLAYS):
        rows = store.read_episodes(finished / name)
        rows = rows.replace({"policy": POLICIES, "scenario_set": SETS})
        by_set = rows["scenario_set"].map(["Crossing", *PEOPLE].index)
        ordered = rows.iloc[by_set.argsort(kind="stable")].reset_index(drop=True)
        store.write_episodes(folder / name, pd.DataFrame(ordered))


def renamed(content: Any) -> Any:
    """Return a record with other names of policies and sets, as keys and as values."""
    known = POLICIES | SETS
    if isinstance(content, dict):
        return {known.get(key, key): renamed(value) for key, value in content.items()}
    if isinstance(content, list):
        return [renamed(value) for value in content]
    return known.get(content, content) if isinstance(content, str) else content


@pytest.fixture(scope="module")
def told(finished: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """Return the folder in which a report was made of planted records, and what it did."""
    here = tmp_path_factory.mktemp("planted")
    planted(finished, here / "results")
    (here / "evil.py").write_text("open('ran', 'w').close()\nattribute = None\n")
    (here / "e.zip").write_bytes(b"cos\nsystem\n(S'touch ran'\ntR.")  # a pickle that runs a command
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, "results"], cwd=here, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return here, json.loads(done.stdout.splitlines()[-1])


def test_a_report_of_planted_records_runs_nothing(told: tuple[Path, dict[str, Any]]) -> None:
    here, result = told
    assert result["code"] == 0
    assert (here / "results" / "report.html").exists()
    assert not (here / "ran").exists()
    assert "evil" not in result["modules"]


def test_a_report_loads_neither_engines_nor_policies(told: tuple[Path, dict[str, Any]]) -> None:
    _, result = told
    never = ("sim", "envs.vector", "envs.corridor", "policies.learned", "evaluation.rollout")
    loaded = [
        name
        for name in result["modules"]
        if name.startswith(tuple(f"hazbot_gym.{each}" for each in never))
    ]
    assert not loaded
    assert not {"pymunk", "torch", "skfuzzy"} & set(result["modules"])


def test_a_policy_whose_name_is_markup_stays_a_name(
    told: tuple[Path, dict[str, Any]], browser: Any
) -> None:
    page = told[0] / "results" / "report.html"
    assert "<img" not in page.read_text(encoding="utf-8")
    browser.open(page, 1280, 900)
    images, names, labels = browser.run(
        """
        const wait = (ms) => new Promise((done) => setTimeout(done, ms));
        while (!document.documentElement.dataset.plots) await wait(20);
        return [
          document.querySelectorAll("img").length,
          [...document.querySelectorAll(".key button")].map((button) => button.dataset.name),
          [...document.querySelectorAll('[data-plot="front"] .textpoint')]
            .map((t) => t.textContent),
        ];
        """
    )
    assert images == 0
    assert MARKUP in names
    assert MARKUP.partition(":")[2] in labels
    assert browser.complaints == []


def test_records_of_other_types_are_one_line(finished: Path, tmp_path: Path) -> None:
    for name in (store.MANIFEST, store.SUMMARY, store.COSTS):
        folder = Path(shutil.copytree(finished, tmp_path / name))
        (folder / store.REPORT).unlink(missing_ok=True)
        record = files.read_json(folder / name)
        files.write_json(folder / name, wrong(record))
        with refused("no finished study"):
            report.write_report(folder)
        assert not (folder / store.REPORT).exists()


def wrong(content: Any) -> Any:
    """Return a record of the same shape with a text for every number."""
    if isinstance(content, dict):
        return {key: wrong(value) for key, value in content.items()}
    if isinstance(content, list):
        return [wrong(value) for value in content]
    return "no number" if isinstance(content, int | float) else content
