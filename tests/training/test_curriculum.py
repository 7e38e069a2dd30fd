"""A curriculum changes the environments of a run, which resumes to the same bits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
import torch

from hazbot_gym.errors import InvalidInput
from hazbot_gym.training.combined_envs import CombinedEnvs
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.run import train

RUN: dict[str, Any] = {
    "worlds": 4,
    "steps": 192,
    "overrides": {"max_episode_steps": 20, "people": {"speeds": {"mean_mps": {"uniform": [1, 2]}}}},
    "options": {"n_steps": 16, "batch_size": 32, "n_epochs": 1},
    "network": {"net_arch": [4]},
    "validation": {"every_steps": 64, "episodes": 1},
}
STAGES = [
    {"overrides": {"people": {"count": [1, 1]}}},
    {"from_step": 64, "overrides": {"people": {"count": [6, 6]}}},
]


def weights(model: Any) -> torch.Tensor:
    return torch.cat([each.detach().flatten() for each in model.policy.parameters()])


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the numbers of people after each reset of a training."""
    seen: list[int] = []
    reset = CombinedEnvs.reset

    def noting(envs: CombinedEnvs) -> Any:
        observations = reset(envs)
        people = envs.parts[0].worlds.state().people  # type: ignore[attr-defined]
        seen.append(int((people["radius"] > 0.0).sum(axis=1).max()))
        return observations

    monkeypatch.setattr(CombinedEnvs, "reset", noting)
    return seen


def test_stages_change_the_people(counts: list[int], tmp_path: Path) -> None:
    train(TrainConfig(**RUN, curriculum=STAGES), tmp_path)
    assert counts[-3:] == [1, 6, 6]


def test_a_function_is_asked_with_the_validations_and_resumes_to_the_same_bits(
    counts: list[int], tmp_path: Path
) -> None:
    asked: list[tuple[int, int]] = []

    def harder(steps: int, validations: Sequence[Mapping[str, Any]]) -> Mapping[str, object]:
        asked.append((steps, len(validations)))
        return {"people": {"count": [1 + len(validations)] * 2}}

    config = TrainConfig(**RUN)
    whole = train(config, tmp_path / "whole", curriculum=harder)
    assert asked == [(0, 0), (64, 1), (128, 2)]
    assert counts[-3:] == [1, 2, 3]

    def interrupted(steps: int, validations: Sequence[Mapping[str, Any]]) -> Mapping[str, object]:
        if steps == 128:
            raise KeyboardInterrupt
        return harder(steps, validations)

    with pytest.raises(KeyboardInterrupt):
        train(config, tmp_path / "parts", curriculum=interrupted)
    resumed = train(config, tmp_path / "parts", resume=True, curriculum=harder)

    assert torch.equal(weights(resumed.model), weights(whole.model))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"curriculum": [{"overrides": {"tier": "sonar"}}]}, "curriculum: tier: .* same in all"),
        ({"curriculum": [{"overrides": {"peple": 3}}]}, "curriculum: peple: unknown key"),
        ({"curriculum": STAGES, "engine": "pymunk"}, "allowed is 'batched'"),
        ({"curriculum": STAGES[::-1]}, "each must begin after the one before"),
    ],
)
def test_a_curriculum_that_is_not_possible_is_refused(
    changes: dict[str, Any], reason: str, tmp_path: Path
) -> None:
    with pytest.raises(InvalidInput, match=reason):
        train(load_training(**{**RUN, **changes}), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("given", [5, lambda: {}, lambda step: {}, lambda step, *, found: {}])
def test_what_is_no_function_of_two_arguments_is_refused(given: Any, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="curriculum: given .*, allowed is a function"):
        train(TrainConfig(), tmp_path / "run", curriculum=given)
    assert not (tmp_path / "run").exists()


def test_a_function_that_returns_no_overrides_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="curriculum: given 3, allowed is a mapping"):
        train(TrainConfig(**RUN), tmp_path, curriculum=lambda *_: 3)  # type: ignore[arg-type,return-value]
