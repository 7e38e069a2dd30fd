"""The spaces of the environment without the environment, and observations to answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.task.observation import LAYOUTS


class Blank(gymnasium.Env[Any, Any]):
    """The spaces of the environment, and nothing else."""

    def __init__(self, tier: str = "tracks", levels: int = 0) -> None:
        layout = LAYOUTS[tier]
        self.observation_space = gymnasium.spaces.Box(layout.low, layout.high, dtype=np.float32)
        box = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
        self.action_space = gymnasium.spaces.Discrete(levels) if levels else box

    def reset(self, **_: Any) -> tuple[Any, dict[str, Any]]:
        return self.observation_space.sample(), {}


@pytest.fixture
def blank() -> type[Blank]:
    return Blank


@pytest.fixture
def seen() -> Callable[..., Any]:
    """Return what draws observations of a tier, (500, width)."""

    def draw(tier: str = "tracks") -> Any:
        layout, rng = LAYOUTS[tier], np.random.default_rng(0)
        return rng.uniform(layout.low, layout.high, (500, layout.width)).astype(np.float32)

    return draw
