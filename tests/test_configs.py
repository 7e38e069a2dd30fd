"""Every file in ``configs/`` loads: studies, training runs, and deltas of an environment."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.config import make_config
from hazbot_gym.study.config import load_study
from hazbot_gym.training.config import load_training
from hazbot_gym.utils.yaml_loader import read_yaml

ROOT = Path(__file__).parents[1]
FILES = sorted((ROOT / "configs").glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_config_file_loads(path: Path) -> None:
    if "algorithm" in read_yaml(path):
        load: Callable[..., Any] = load_training
        assert load(path).environments()
    else:
        load = load_study if path.stem.startswith("study") else make_config
    assert load(path) != load()


def test_the_quick_study_of_the_makefile_is_there() -> None:
    assert ROOT / "configs" / "study.yaml" in FILES
    assert "--config configs/study.yaml" in (ROOT / "Makefile").read_text(encoding="utf-8")
