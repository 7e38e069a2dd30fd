"""Specialists: trained first, one in each environment, then imitated; resumable; refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.policies.actor_file import read
from hazbot_gym.training import run
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.run import train
from hazbot_gym.training.specialists import folder_of, specialists_of
from hazbot_gym.utils.files import read_json
from tests.refusals import refused

SPECIALISTS: dict[str, Any] = {
    "algorithm": "qrdqn",
    "overrides": {"action_type": "discrete"},
    "worlds": 2,
    "steps": 200,
    "options": {"learning_starts": 50, "buffer_size": 200, "batch_size": 16},
    "network": {"net_arch": [4], "n_quantiles": 3},
    "validation": {"every_steps": 100, "episodes": 1},
}
RUN: dict[str, Any] = {
    "env": ["hazbot_gym/Corridor-v1", "hazbot_gym/Crossing-v1"],
    "overrides": {"max_episode_steps": 20},
    "worlds": 4,
    "steps": 128,
    "options": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "network": {"net_arch": [4]},
    "imitation": {"specialists": SPECIALISTS, "decisions": 96, "epochs": 1, "batch_size": 32},
    "validation": {"every_steps": 64, "episodes": 2},
}


def made(**changes: Any) -> TrainConfig:
    return load_training(None, **{**RUN, **changes})


def test_a_run_trains_a_specialist_in_each_environment_and_starts_from_them(
    tmp_path: Path,
) -> None:
    result = train(made(seed=3), tmp_path / "run")
    for env in RUN["env"]:
        trained = read(folder_of(env, tmp_path / "run") / "policy.npz").about["training"]["config"]
        assert (trained["env"], trained["seed"]) == ([env], 3)
        assert trained["overrides"] == {"max_episode_steps": 20, "action_type": "discrete"}
    found = read_json(tmp_path / "run" / "result.json")
    assert found["specialists_seconds"] > 0.0
    assert found["imitation_seconds"] > 0.0
    assert read(result.policy).about["training"]["config"]["imitation"]["specialists"]


def test_a_killed_run_goes_on_with_the_specialists_that_are_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = train(made(), tmp_path / "whole")

    def killed(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(run, "imitate", killed)
        with pytest.raises(KeyboardInterrupt):
            train(made(), tmp_path / "killed")
    first = folder_of(RUN["env"][0], tmp_path / "killed") / "policy.npz"
    before = first.stat().st_mtime_ns
    resumed = train(made(), tmp_path / "killed", resume=True)
    assert first.stat().st_mtime_ns == before
    for mine, other in zip(
        whole.model.policy.state_dict().values(),
        resumed.model.policy.state_dict().values(),
        strict=True,
    ):
        assert mine.equal(other)


def test_runs_without_specialists_are_the_runs_they_were() -> None:
    imitation = {"teacher": "idm", "decisions": 96}
    plain = load_training(None, **{**RUN, "imitation": imitation})
    assert not specialists_of(plain)
    assert plain.identity() != made().identity()
    # of the commit before there were specialists
    assert plain.identity() == "be2f0c45cff5b7b1"


@pytest.mark.parametrize(
    ("imitation", "complaint"),
    [
        ({"specialists": SPECIALISTS, "teacher": "idm"}, "teacher ... with specialists"),
        ({"specialists": {**SPECIALISTS, "env": "Crossing-v1"}}, "specialists.env ... run itself"),
        ({"specialists": {**SPECIALISTS, "seed": 1}}, "specialists.seed ... run itself"),
        ({"specialists": {"algoritm": "ppo"}}, "imitation.specialists.algoritm: unknown key"),
        ({"specialists": {"algorithm": "qrdqn"}}, "options: qrdqn ... discrete"),
    ],
)
def test_mistakes_are_one_line_and_nothing_is_written(
    imitation: dict[str, Any], complaint: str, tmp_path: Path
) -> None:
    with refused(complaint):
        train(made(imitation=imitation), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_only_ppo_starts_from_specialists() -> None:
    with refused("imitation ... specialists ... 'dagger' ... 'ppo'"):
        made(algorithm="dagger", options={})
