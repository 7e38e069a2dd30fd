"""A study that tunes and trains before it compares: small, killed, and resumed."""

from __future__ import annotations

import io
import multiprocessing
import os
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from rich.console import Console

from hazbot_gym.evaluation.workers import Here
from hazbot_gym.study import candidates, store
from hazbot_gym.study import run as comparison
from hazbot_gym.study.config import Learner, StudyConfig, load_study
from hazbot_gym.study.report import page as report
from hazbot_gym.study.run import run_study
from hazbot_gym.utils import provenance
from hazbot_gym.utils.files import read_json, write_text
from tests.refusals import refused

KILLS = 5
TRAINING = {
    "env": "hazbot_gym/Crossing-v1",
    "worlds": 4,
    "steps": 512,
    "overrides": {"max_episode_steps": 20},
    "options": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "network": {"net_arch": [4]},
    "validation": {"every_steps": 128, "episodes": 1},
    "seed": 3,
}
STUDY = {
    "policies": ["constant:1.0"],
    "tuned": ["constant"],
    "trials": 4,
    "trial_episodes": 1,
    "sets": ["Crossing", "E*"],
    "episodes": 4,
    "resamples": 200,
}


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> StudyConfig:
    folder = tmp_path_factory.mktemp("config")
    training = folder / "tiny.yaml"
    write_text(training, yaml.safe_dump(TRAINING))
    learner = {"name": "tiny ppo", "config": str(training), "seeds": 2}
    write_text(folder / "study.yaml", yaml.safe_dump({**STUDY, "learners": [learner]}))
    return load_study(folder / "study.yaml")


def run_here(study: StudyConfig, out: Path) -> None:
    """Run a study in this very process, which is quicker than to start others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparison, "_prepare", prepare_here)
        run_study(study, out, workers=1)


def prepare_here(waiting: list[candidates.Job], *_: Any, **__: Any) -> None:
    for job in waiting:
        job.run(Here())


@pytest.fixture(scope="module")
def finished(study: StudyConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("study") / "out"
    run_here(study, out)
    return out


def test_all_who_take_part_have_rows_and_learners_one_for_each_seed(
    study: StudyConfig, finished: Path
) -> None:
    assert study.names == ("constant:1.0", "constant, tuned", "tiny ppo")
    rows = pd.read_parquet(finished / store.EPISODES)
    counts = rows.groupby(["policy", "training_seed"]).size()
    assert counts.to_dict() == {
        ("constant:1.0", 0): 5,  # four of Crossing, the one of E*
        ("constant, tuned", 0): 5,
        ("tiny ppo", 0): 5,
        ("tiny ppo", 1): 5,
    }
    keys = rows.groupby(["scenario_set", "episode"])["scenario_key"].nunique()
    assert (keys == 1).all()


def test_summary_counts_training_seeds_as_runs(finished: Path) -> None:
    summary = read_json(finished / store.SUMMARY)
    block = summary["sets"]["Crossing"]
    assert block["tiny ppo"]["training_seeds"] == 2
    assert block["tiny ppo"]["episodes"] == 8
    assert block["constant:1.0"]["training_seeds"] == 1
    difference = block["tiny ppo"]["difference"]["delay_s"]
    assert difference["low"] <= difference["mean"] <= difference["high"]
    assert 0.0 < difference["p"] <= difference["p_holm"] <= 1.0
    rows = pd.read_parquet(finished / store.EPISODES)
    mine = rows[(rows["policy"] == "tiny ppo") & (rows["scenario_set"] == "Crossing")]
    assert block["tiny ppo"]["metrics"]["return"]["mean"] == pytest.approx(mine["return"].mean())


def test_manifest_names_files_from_the_folder_which_can_be_moved(
    finished: Path, tmp_path: Path
) -> None:
    moved = tmp_path / "elsewhere"
    shutil.copytree(finished, moved)
    manifest = read_json(moved / store.MANIFEST)
    assert manifest["candidates"]["tiny ppo"] == [
        f"learned:path=trained/tiny_ppo/{seed}/policy.npz" for seed in (0, 1)
    ]
    page = report.make_page(report.read(moved))
    assert "tiny ppo" in page
    assert "constant, tuned" in page


def test_a_second_run_has_nothing_to_do_and_changes_nothing(
    study: StudyConfig, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (finished / store.SUMMARY).read_bytes()
    assert candidates.jobs(study, finished) == []
    monkeypatch.setattr(store, "write_rows", lambda *_: pytest.fail("it was done already"))
    run_here(study, finished)
    assert (finished / store.SUMMARY).read_bytes() == before


def test_a_search_of_other_code_is_begun_anew(
    study: StudyConfig, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(finished, tmp_path / "out")
    monkeypatch.setattr(provenance, "stamp", lambda *_: "other code")
    (job,) = candidates.jobs(study, tmp_path / "out")
    assert isinstance(job, candidates.SearchJob)
    assert not (tmp_path / "out" / "tuned" / "constant.json").exists()


@pytest.mark.parametrize(
    ("file", "told"),
    [
        ("trained/tiny_ppo/1/policy.npz", "a damaged run is done again"),
        ("trained/tiny_ppo/1/result.json", "a damaged run is done again"),
        ("trained/tiny_ppo/1/manifest.json", "a run is begun anew"),
        ("tuned/constant.json", "a search of other code or data is begun anew"),
    ],
)
def test_what_was_prepared_and_is_damaged_is_done_again_and_said_so(
    study: StudyConfig, finished: Path, tmp_path: Path, file: str, told: str
) -> None:
    out, console = tmp_path / "out", Console(file=io.StringIO(), width=500)
    shutil.copytree(finished, out)
    data = (out / file).read_bytes()
    (out / file).write_bytes(data[:200] + b"?" + data[201:])
    (job,) = candidates.jobs(study, out, console=console)
    assert told in console.file.getvalue()  # type: ignore[attr-defined]
    job.run(Here())
    assert candidates.jobs(study, out) == []
    if file.endswith((".npz", "constant.json")):
        assert (out / file).read_bytes() == data


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_study_killed_at_random_moments_ends_with_the_same_summary(
    study: StudyConfig, finished: Path, tmp_path: Path
) -> None:
    out, rng = tmp_path / "killed", np.random.default_rng(1)
    context: Any = multiprocessing.get_context("fork")
    for _ in range(KILLS):
        files, is_before = int(rng.integers(1, 5)), bool(rng.integers(2))
        process = context.Process(target=run_until_killed, args=(study, out, files, is_before))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL
        assert not (out / store.SUMMARY).exists()
    run_here(study, out)
    assert (out / store.SUMMARY).read_bytes() == (finished / store.SUMMARY).read_bytes()


def run_until_killed(study: StudyConfig, out: Path, files: int, is_before: bool) -> None:
    """Run a study that is killed right before or after it puts one more file in its place."""
    put = Path.replace
    left = files

    def put_or_die(beside: Path, path: Path) -> Path:
        nonlocal left
        left -= 1
        if not left and is_before:
            os.kill(os.getpid(), signal.SIGKILL)
        put(beside, path)
        if not left:
            os.kill(os.getpid(), signal.SIGKILL)
        return path

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Path, "replace", put_or_die)
        run_here(study, out)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"tuned": ["telepathy"]}, "telepathy"),
        ({"learners": [{"name": "a", "config": "missing.yaml"}]}, "missing.yaml"),
        ({"reference": "nobody"}, "constant, tuned"),
    ],
)
def test_what_cannot_take_part_is_refused_before_anything_is_written(
    changes: dict[str, Any], named: str, tmp_path: Path
) -> None:
    with refused(named):
        run_study(load_study(**{**STUDY, **changes}), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("learner", "named"),
    [
        ({"changes": {"steps": "many"}}, "steps ... 'many'"),
        ({"changes": {"env": "Nowhere-v1"}}, "env ... 'Nowhere-v1'"),
        ({"changes": {"options": {"n_stps": 3}}}, "options.n_stps"),
        ({"changes": {"network": {"activation": "ramp"}}}, "network.activation ... 'ramp'"),
        ({"changes": {"overrides": {"tear": "sonar"}}}, "tear"),
        ({"changes": {"algorithm": "sac"}}, "options.n_epochs"),
        ({"changes": {"worlds": 1, "env": ["Crossing-v1", "Circle-v1"]}}, "worlds ... 1"),
        ({"changes": {"seed": 2**32 - 5}, "seeds": 6}, "seed ... 4294967296"),
    ],
)
def test_a_learner_that_cannot_be_trained_is_refused_before_anything_is_written(
    study: StudyConfig, learner: dict[str, Any], named: str, tmp_path: Path
) -> None:
    learner = {"name": "pupil", "config": str(study.learners[0].config), **learner}
    with refused(f"learners ... 'pupil' ... {named}"):
        run_study(load_study(**{**STUDY, "learners": [learner]}), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_training_files_are_found_from_the_study_file_and_count_by_their_contents(
    study: StudyConfig, tmp_path: Path
) -> None:
    for name in ("one", "two"):
        folder = tmp_path / name
        write_text(folder / "tiny.yaml", yaml.safe_dump(TRAINING))
        learner = {"name": "tiny ppo", "config": "tiny.yaml", "seeds": 2}
        write_text(folder / "study.yaml", yaml.safe_dump({**STUDY, "learners": [learner]}))
        found = load_study(folder / "study.yaml")
        assert found.learners[0].config == folder / "tiny.yaml"
        assert found.identity() == study.identity()
    before = load_study(tmp_path / "two" / "study.yaml")
    write_text(tmp_path / "two" / "tiny.yaml", yaml.safe_dump({**TRAINING, "steps": 1024}))
    assert before.identity() == study.identity()  # a config holds what it has read
    assert candidates.training_of(before.learners[0], 0).steps == TRAINING["steps"]
    assert load_study(tmp_path / "two" / "study.yaml").identity() != study.identity()


def test_names_must_differ(study: StudyConfig) -> None:
    learner = {"name": "constant, tuned", "config": str(study.learners[0].config)}
    with refused("twice"):
        load_study(**{**STUDY, "learners": [learner]})


def test_changes_of_a_learner_go_into_the_sections_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "run.yaml"
    path.write_text("overrides: {reward: {burden: 0.0}, tier: sonar}\nsteps: 7")
    changes = {"overrides": {"reward": {"intrusion": -1.0}}}
    kept, cut = (Learner(name="x", config=path, changes=changes, steps=n) for n in (None, 5))
    run = candidates.training_of(kept, 2)
    assert run.overrides == {"reward": {"burden": 0.0, "intrusion": -1.0}, "tier": "sonar"}
    assert (run.steps, run.seed, candidates.training_of(cut, 0).steps) == (7, 2, 5)


@pytest.mark.parametrize("teacher", ["my_own:Teacher", "learned:evil.zip"])
def test_a_teacher_that_runs_code_is_refused_before_anything_is_written(
    teacher: str, tmp_path: Path
) -> None:
    file = tmp_path / "train.yaml"
    write_text(file, yaml.safe_dump({**TRAINING, "algorithm": "dagger", "options": {}}))
    learner = Learner(name="pupil", config=file, changes={"imitation": {"teacher": teacher}})
    study = StudyConfig(policies=("constant:1.0",), learners=(learner,), sets=("E*",))
    with refused("--allow-"):
        run_study(study, tmp_path / "out")
    assert not (tmp_path / "out").exists()
