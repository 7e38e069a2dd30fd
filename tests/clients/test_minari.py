"""Minari's own collector records episodes of an environment."""

from __future__ import annotations

from pathlib import Path

import gymnasium
import numpy as np
import pytest

pytest.importorskip("minari")
pytest.importorskip("jax", reason="needs minari[create]")

pytestmark = [pytest.mark.clients, pytest.mark.slow, pytest.mark.filterwarnings("default")]


def test_an_episode_is_collected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from minari import DataCollector

    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    env = DataCollector(
        gymnasium.make("hazbot_gym/Corridor-v1", max_episode_steps=20), record_infos=True
    )
    env.reset(seed=0)
    rewards = [env.step(np.ones(1, np.float32))[1] for _ in range(20)]
    dataset = env.create_dataset("some/corridor-v0")
    assert next(iter(dataset)).rewards.tolist() == rewards
