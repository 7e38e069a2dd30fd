"""A small finished study."""

from __future__ import annotations

from pathlib import Path

import pytest

from hazbot_gym.study.config import load_study
from hazbot_gym.study.run import run_study


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished study, which tests only read."""
    out = tmp_path_factory.mktemp("finished") / "study"
    study = load_study(
        policies=["fuzzy_expert", "stop_on_sight", "constant:0.5", "constant:1.0"],
        sets=["E*", "Crossing", "Corridor"],
        episodes=4,
        resamples=100,
    )
    run_study(study, out, workers=1)
    return out
