from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from hazbot_gym.bench import cases as bench_cases
from hazbot_gym.bench.cases import CARTPOLE, CORRIDOR, CorridorStepper, Stepper, make_cases


def test_stepping_goes_on_over_the_end_of_an_episode() -> None:
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.make(CARTPOLE))
    Stepper(env).run(500)
    assert env.episode_count > 5


def test_worlds_of_a_batch_stand_at_different_points_of_their_episodes() -> None:
    times = CorridorStepper(16, 2, spread=20).envs.state().time_s
    assert len(set(times.tolist())) > 5
    assert times.max() <= 2.0 + 1e-9


def test_every_case_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_cases, "WORLDS", (1, 8))
    cases, notes = make_cases(spread=2)
    assert next(iter(cases)) == CARTPOLE
    assert {CORRIDOR, "batched, 8 worlds, 10 people", "policy constant, 1 observation"} < set(cases)
    assert ("SB3 adapter, 1024 worlds, 4 people" in cases) == (notes == [])
    sizes = {name: case.size for name, case in cases.items()}
    assert sizes[CARTPOLE] == sizes["policy fuzzy_expert, 1 observation"] == 1
    assert sizes["policy fuzzy_expert, 1024 observations"] == 1024
    for case in cases.values():
        case.run(2)


def test_an_adapter_that_cannot_be_had_is_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any) -> None:
        raise bench_cases.MissingExtra("stable-baselines3", "train")

    monkeypatch.setattr(bench_cases, "WORLDS", (1,))
    monkeypatch.setattr(bench_cases, "Sb3Stepper", missing)
    cases, (note,) = make_cases(spread=1)
    assert not any("SB3" in name for name in cases)
    assert "hazbot-gym[train]" in note
    assert np.all([case.size for case in cases.values()])
