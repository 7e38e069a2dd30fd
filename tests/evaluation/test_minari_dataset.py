"""Minari data sets of a policy's episodes."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.errors import MissingExtra
from hazbot_gym.evaluation.rollout import evaluate
from tests.refusals import refused

MODULE = "hazbot_gym.evaluation.minari_dataset"
SHORT = {"max_episode_steps": 30}


@pytest.fixture
def write_dataset() -> Any:
    pytest.importorskip("minari")
    pytest.importorskip("h5py")
    return importlib.import_module(MODULE).write_dataset


def loaded(folder: Path) -> Any:
    import minari

    return minari.MinariDataset(str(folder / "data"))


@pytest.mark.parametrize(
    ("policy", "env", "overrides"),
    [
        ("random", "Crossing-v1", {}),
        ("ppo", "Corridor-v1", {"tier": "sonar", "place": "circle"}),
        ("fuzzy_expert", "Inspection-v1", {"action_type": "discrete"}),
        ("constant", "Corridor-v1", {"drive": {"acceleration_mps2": {"uniform": [0.3, 0.6]}}}),
    ],
)
def test_recovered_environment_replays_the_rewards_to_the_bit(
    policy: str, env: str, overrides: dict[str, object], write_dataset: Any, tmp_path: Path
) -> None:
    folder = tmp_path / "some-v0"
    write_dataset(policy, env, folder, episodes=2, overrides={**SHORT, **overrides})

    dataset = loaded(folder)
    recovered = dataset.recover_environment()
    starts = list(dataset.storage.get_episode_metadata(dataset.episode_indices))
    assert len(starts) == 2
    for episode, start in zip(dataset, starts, strict=True):
        observation, _ = recovered.reset(seed=start["seed"])
        seen, rewards, ends = [observation], [], []
        for action in episode.actions:
            observation, reward, *end, _ = recovered.step(action)
            seen.append(observation)
            rewards.append(reward)
            ends.append(end)
        assert rewards == episode.rewards.tolist()
        np.testing.assert_array_equal(seen, episode.observations)
        np.testing.assert_array_equal(
            ends, np.stack([episode.terminations, episode.truncations], axis=1)
        )


def test_episodes_are_those_of_evaluate_with_every_info(
    write_dataset: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # relative folders work
    written = write_dataset(
        "idm", "Crossing-v1", Path("rule-v0"), episodes=3, seed=5, overrides=SHORT
    )
    rows = evaluate("idm", "Crossing-v1", episodes=3, seed=5, overrides=SHORT, engine="pymunk")

    dataset = loaded(tmp_path / "rule-v0")
    assert written.mean_return == pytest.approx(np.mean([row["return"] for row in rows]))
    for episode, row in zip(dataset, rows, strict=True):
        assert episode.infos["scenario_key"][0] == int(row["scenario_key"])
        assert episode.infos["outcome"][-1].decode() == row["outcome"]
        assert episode.infos["time_s"].shape == (len(episode) + 1,)
        terms = episode.infos["reward_terms"]
        assert terms["intrusion"].shape == (len(episode) + 1,)
    assert dataset.storage.metadata["algorithm_name"] == "idm"


@pytest.mark.parametrize(
    ("name", "complaint"),
    [("there-v0", "out: ... exists"), ("no_version", "out: ... version"), ("a b-v0", "out: ...")],
)
def test_folders_that_exist_or_are_no_id_are_refused(
    name: str, complaint: str, write_dataset: Any, tmp_path: Path
) -> None:
    (tmp_path / "there-v0").mkdir()
    with refused(complaint):
        write_dataset("idm", "Crossing-v1", tmp_path / name, episodes=1)
    assert [path.name for path in tmp_path.iterdir()] == ["there-v0"]


def test_an_interrupted_run_leaves_nothing(write_dataset: Any, tmp_path: Path) -> None:
    def interrupt() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_dataset(
            "constant", "Crossing-v1", tmp_path / "some-v0",
            episodes=2, overrides=SHORT, on_progress=interrupt,
        )  # fmt: skip
    assert list(tmp_path.iterdir()) == []


def test_missing_minari_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "minari", None)
    monkeypatch.delitem(sys.modules, MODULE, raising=False)
    with refused("minari ... pip install 'hazbot-gym[datasets]'", error=MissingExtra):
        importlib.import_module(MODULE)
