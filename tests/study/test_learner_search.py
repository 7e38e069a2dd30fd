"""Hyperparameter search of a learner: proposals, training times, resuming, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from hazbot_gym.study import learner_search
from hazbot_gym.study.learner_search import BEST, LearnerSearch, laid_over, load_search, search
from hazbot_gym.training.config import load_training
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.yaml_loader import read_yaml
from tests.refusals import refused

CONFIGS = Path(__file__).parents[2] / "configs"
BASE: dict[str, Any] = {
    "algorithm": "sac",
    "overrides": {"max_episode_steps": 20},
    "worlds": 4,
    "steps": 400,
    "learning_rate": 1e-3,
    "options": {"learning_starts": 50, "buffer_size": 400, "batch_size": 16, "gradient_steps": 1},
    "network": {"net_arch": [4]},
    "validation": {"every_steps": 200, "episodes": 2},
}
SPACE: dict[str, Any] = {
    "learning_rate": {"log_uniform": [1e-4, 1e-2]},
    "options.gradient_steps": {"choice": [1, 2]},
    "network.net_arch": {"choice": [[4], [8, 8]]},
}


def plan(**changes: Any) -> LearnerSearch:
    return LearnerSearch.model_validate({"config": "base.yaml", "space": SPACE, **changes})


def test_the_first_trial_has_the_values_of_the_file_and_the_best_one_is_written(
    tmp_path: Path,
) -> None:
    record = search(plan(trials=3), BASE, tmp_path / "out")
    first, *others = record["trials"]
    assert first["values"]["options.gradient_steps"] == 1
    assert first["steps"] == 400
    assert all(1e-4 <= trial["values"]["learning_rate"] <= 1e-2 for trial in others)
    returns = [trial["return"] for trial in record["trials"]]
    assert record["best"] == returns.index(max(returns))
    assert read_json(tmp_path / "out" / "search.json")["trials"] == record["trials"]
    again = load_training(tmp_path / "out" / BEST)
    run = read_json(tmp_path / "out" / f"trial-{record['best']:03d}" / "manifest.json")
    assert again.identity() == run["run"]


def test_a_killed_search_goes_on_and_a_longer_one_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = search(plan(trials=3), BASE, tmp_path / "whole")
    run = learner_search._run

    def killed(trial: Any, base: Any, folder: Path, allowed: Any) -> None:
        if folder.name == "trial-001":
            raise KeyboardInterrupt
        run(trial, base, folder, allowed)

    with monkeypatch.context() as patch:
        patch.setattr(learner_search, "_run", killed)
        with pytest.raises(KeyboardInterrupt):
            search(plan(trials=2), BASE, tmp_path / "killed")
    assert read_json(tmp_path / "killed" / "search.json")["trials"][1]["return"] is None
    resumed = search(plan(trials=3), BASE, tmp_path / "killed")
    for one, other in zip(whole["trials"], resumed["trials"], strict=True):
        assert (one["values"], one["return"]) == (other["values"], other["return"])


def test_a_trial_takes_about_the_given_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    speed, start = 100.0, 3.0  # steps a second after three seconds of warming up

    def train(config: Any, folder: Any, **_: Any) -> None:
        took = start + config.steps / speed
        learner_search.write_json(
            Path(folder, "result.json"), {"steps": config.steps, "training_seconds": took}
        )

    monkeypatch.setattr(learner_search, "train", train)
    steps = learner_search._steps_in(BASE, 60.0, learner_search.NO_CODE)
    assert steps == pytest.approx((60.0 - start) * speed, rel=0.01)


def test_values_are_laid_over_by_dotted_names() -> None:
    base = {"options": {"gamma": 0.9, "tau": 0.1}, "worlds": 4}
    assert laid_over(base, {"options.tau": 0.2, "worlds": 8}) == {
        "options": {"gamma": 0.9, "tau": 0.2},
        "worlds": 8,
    }
    assert base["worlds"] == 4


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"space": {}}, "space ... at least 1"),
        ({"space": {"steps": {"choice": [1]}}}, "steps ... same"),
        ({"space": {"worlds": {"normal": [1, 2]}}}, "worlds ... normal ... log_uniform"),
        ({"space": {"worlds": {"choice": []}}}, "worlds ... no values"),
        ({"space": {"worlds": {"uniform": [3, 1]}}}, "worlds ... [3, 1] ... uniform: [low, high]"),
        ({"space": {"learning_rate": {"log_uniform": [0, 1]}}}, "learning_rate ... log_uniform"),
        ({"space": {"learning_rate": {"uniform": [0, True]}}}, "learning_rate ... uniform"),
        ({"seconds": 0}, "seconds ... 0"),
        ({"config": None}, "config ... None ... string"),
        ({"budget": 3}, "budget: unknown key ... seconds"),
    ],
)
def test_mistakes_in_the_file_are_one_line(
    changes: dict[str, Any], complaint: str, tmp_path: Path
) -> None:
    path = tmp_path / "search.yaml"
    path.write_text(yaml.safe_dump({"config": "base.yaml", "space": SPACE, **changes}))
    with refused(complaint):
        load_search(path)


def test_a_file_that_is_no_search_is_told_what_is_missing() -> None:
    with refused("config: is missing"):
        load_search(CONFIGS / "ppo.yaml")


@pytest.mark.parametrize(
    ("space", "complaint"),
    [
        ({"options.gama": {"choice": [0.9]}}, "space.options.gama ... no value"),
        ({"worlds.inner": {"choice": [1]}}, "space.worlds.inner ... no value"),
        ({"worlds": {"choice": [8, 16]}}, "space.worlds ... 4 ... [8, 16]"),
        ({"learning_rate": {"uniform": [0.1, 1]}}, "space.learning_rate ... 0.001"),
    ],
)
def test_a_space_fits_its_training_file(
    space: dict[str, Any], complaint: str, tmp_path: Path
) -> None:
    with refused(complaint):
        search(plan(space=space), BASE, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_only_the_folder_of_the_same_search_is_resumed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    with refused("out ... no search's"):
        search(plan(), BASE, out)
    (out / "notes.txt").unlink()
    learner_search.write_json(out / "search.json", {"search": "another"})
    with refused("out ... another search"):
        search(plan(), BASE, out)


@pytest.mark.parametrize("path", sorted((CONFIGS / "search").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_shipped_space_fits_its_training_file(path: Path) -> None:
    shipped = load_search(path)
    base = read_yaml(path.parent / shipped.config, "config")
    first = learner_search._first(shipped, base)
    assert learner_search.training_of(laid_over(base, first)) == load_training(
        path.parent / shipped.config
    )
