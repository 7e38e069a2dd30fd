"""The settings for rl-zoo3 are those that ``docs/make_rl_zoo3.py`` writes now."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs"))

from make_rl_zoo3 import FILES, WRITTEN, settings, text  # noqa: E402


@pytest.mark.parametrize("algorithm", FILES)
def test_every_file_is_up_to_date(algorithm: str) -> None:
    written = (WRITTEN / f"{algorithm}.yml").read_text(encoding="utf-8")
    assert written == text(FILES[algorithm])


def test_there_are_no_others() -> None:
    assert {path.stem for path in WRITTEN.iterdir()} == set(FILES)


def test_rollouts_and_updates_per_action_stay_as_they_are() -> None:
    common = {"worlds": 64, "steps": 10, "action_repeat": 4, "learning_rate": 0.1}
    network = {"net_arch": [8], "activation": "relu"}
    ppo = settings(common | {"options": {"n_steps": 4}, "network": network})
    assert ppo["n_envs"] * ppo["n_steps"] == 64 * 4
    sac = settings(common | {"options": {"gradient_steps": 16}, "network": network})
    assert sac["gradient_steps"] / sac["n_envs"] == 16 / 64
