from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.bench import once
from hazbot_gym.bench.once import compile_times, evaluation, memory, spread_of
from hazbot_gym.envs.vector import CorridorVectorEnv


def test_spread_is_median_and_quartiles() -> None:
    found = spread_of([5.0, 1.0, 2.0, 3.0, 4.0], "time_s")
    assert found == {"time_s": 3.0, "time_s_quartiles": [2.0, 4.0]}


def test_compiling_happens_in_a_cache_folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    folders: list[str | None] = []

    def first_episode_s(engine: str, environment: dict[str, str]) -> float:
        folders.append(environment.get("NUMBA_CACHE_DIR"))
        return float(len(folders))

    monkeypatch.setattr(once, "first_episode_s", first_episode_s)
    found = compile_times(True, turns=2)
    assert found["batched"]["cold_s"] == 1.0
    assert found["batched"]["cached_s"] == 2.5
    assert folders[0] == folders[1] == folders[2] != folders[3]
    assert not any(Path(str(folder)).exists() for folder in folders)
    folders.clear()
    assert "cold_s" not in compile_times(False, turns=1)["pymunk"]
    assert set(folders) == {None}


def test_a_world_takes_some_kilobytes_and_no_more_with_time() -> None:
    found = memory(worlds=1024, people=4, steps=200)
    assert 1_000 < found["bytes_a_world"] < 16_000
    assert found["growth_bytes_a_world"] < 2  # an object for each call would be 10


def test_an_object_left_by_each_step_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[list[int]] = []
    step = CorridorVectorEnv.step

    def leaking(*arguments: Any, **named: Any) -> Any:
        left.append([len(left)])
        return step(*arguments, **named)

    monkeypatch.setattr(CorridorVectorEnv, "step", leaking)
    assert memory(worlds=1024, people=4, steps=200)["growth_bytes_a_world"] > 10


def test_evaluation_counts_episodes_and_steps() -> None:
    found = evaluation(episodes=2, turns=2)
    assert found["episodes"] == 2
    assert found["steps"] > 100
    assert found["seconds"] > 0.0
    assert "note" not in found
