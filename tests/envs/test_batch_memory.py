"""Memory of a world, which does not grow with time."""

from __future__ import annotations

import gc
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hazbot_gym.bench import once
from hazbot_gym.envs.registration import ENVIRONMENTS
from hazbot_gym.envs.vector import CorridorVectorEnv


def traced_bytes(worlds: int, **arguments: Any) -> int:
    """Return the memory that a batch holds after its first decision, Python objects included."""
    gc.collect()
    tracemalloc.start()
    envs = CorridorVectorEnv(worlds, **arguments)
    envs.reset(seed=0)
    envs.step(np.zeros((worlds, 1)))
    gc.collect()
    size = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return size


def bytes_per_world(few: int = 16, many: int = 528, **arguments: Any) -> float:
    """Return the memory of one more world.

    The first batch is not counted: it compiles and fills caches of the process. Other objects of
    the process come and go by some kilobytes, a few bytes for each of so many worlds.
    """
    traced_bytes(few, **arguments)
    sizes = [traced_bytes(worlds, **arguments) for worlds in (few, many)]
    return (sizes[1] - sizes[0]) / (many - few)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_world_takes_16_kilobytes_at_most(name: str) -> None:
    assert bytes_per_world(preset=ENVIRONMENTS[name][1], threads=1) <= 16_000


@pytest.mark.parametrize("model", ["replay", "seeded"])
def test_a_world_among_real_people_does_not_take_more(model: str, tracks_dir: Path) -> None:
    size = bytes_per_world(tracks=str(tracks_dir), people={"model": model}, threads=1)
    assert size <= 16_000


def test_decisions_leave_nothing_behind_in_memory() -> None:
    envs = CorridorVectorEnv(64, threads=1, max_episode_steps=50)
    envs.reset(seed=0)
    tracemalloc.start()
    sizes = []
    for _ in range(3):
        for _ in range(300):
            envs.step(np.ones((64, 1)))
        sizes.append(once.traced_bytes())
    tracemalloc.stop()
    assert sizes[2] - sizes[1] < 2_000  # an object for each call would be 8,400
