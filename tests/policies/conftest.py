"""The spaces of the environment without the environment, and observations to answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import GAS, ROBOT, TRACK, records
from hazbot_gym.task.observation import LAYOUTS, layout_for
from hazbot_gym.task.observation import observe as write_observation

PATH = straight_path(np.array([[0.0, 0.0], [20.0, 0.0]])).view(np.recarray)


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
    """Return a function that draws observations of a tier, (500, width)."""

    def draw(tier: str = "tracks", *, has_gas: bool = False) -> Any:
        layout, rng = layout_for(tier, has_gas=has_gas), np.random.default_rng(0)
        return rng.uniform(layout.low, layout.high, (500, layout.width)).astype(np.float32)

    return draw


@pytest.fixture
def observe() -> Callable[..., Any]:
    """Return a function that makes the observation of a robot at the origin, driving ahead at v.

    People are given as (x, y, vx, vy); the path ahead is straight.
    """

    def encoded(*people: tuple[float, float, float, float], v: float, command: float = 0.0) -> Any:
        robot = records(ROBOT, 1).view(np.recarray)[0]
        robot.v, robot.command = v, command
        tracks = records(TRACK, len(people)).view(np.recarray)
        for track, (x, y, vx, vy) in zip(tracks, people, strict=True):
            track.visible, track.x, track.y, track.vx, track.vy = 1, x, y, vx, vy
        out = np.zeros(LAYOUTS["tracks"].width, np.float32)
        write_observation(robot, PATH, np.full(4, 4.0), tracks, records(GAS, 0), out)
        return out

    return encoded


@pytest.fixture
def share() -> Callable[..., float]:
    """Return a function that asks a policy for its share of the nominal speed."""

    def asked(policy: Any, observation: Any) -> float:
        return float(policy.predict(observation)[0][0] + 1.0) / 2.0

    return asked
