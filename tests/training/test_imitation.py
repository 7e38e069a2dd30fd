"""A start from a teacher: what is watched, what is learned, and that it is the same each time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from stable_baselines3.common.policies import ActorCriticPolicy

from hazbot_gym import policies
from hazbot_gym.envs.vector import CorridorVectorEnv
from hazbot_gym.task.observation import LAYOUTS
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.imitation import miss, returns_of, teacher_of, watch
from hazbot_gym.training.run import train
from hazbot_gym.training.vec_envs import make_envs
from tests.refusals import refused

QUICK: dict[str, Any] = {
    "worlds": 32,
    "steps": 32,
    "overrides": {"max_episode_steps": 100},
    "options": {"n_steps": 1, "batch_size": 32, "n_epochs": 1, "gamma": 1.0},
    "learning_rate": 1e-9,  # what is seen is what imitation did
    "network": {"net_arch": [32], "activation": "relu"},
    "imitation": {"decisions": 8_000, "epochs": 30, "batch_size": 256},
    "validation": {"every_steps": 100, "episodes": 2},
}


def quick(**changes: Any) -> TrainConfig:
    return load_training(None, **{**QUICK, **changes})


def test_returns_are_summed_back_from_each_end_and_unknown_after_the_last() -> None:
    rewards = np.array([[1.0], [2.0], [4.0], [8.0]])
    ends = np.array([[False], [True], [False], [False]])
    returns, is_known = returns_of(rewards, ends, gamma=0.5)
    assert returns[:2, 0].tolist() == [2.0, 2.0]
    assert is_known[:, 0].tolist() == [True, True, False, False]


def test_an_answer_that_is_clipped_to_the_teachers_is_no_miss() -> None:
    teacher = torch.tensor([[-1.0], [1.0], [-1.0], [0.5]])
    assert miss(torch.tensor([[-1.7], [1.2], [-1.0], [0.5]]), teacher) == 0.0
    assert miss(torch.tensor([[1.7], [0.8], [-0.9], [0.5]]), teacher) > 0.0


TIMED = {"asymmetric_critic": True, "shaping": "free_drive"}
SQUASHED = {
    "options": {**QUICK["options"], "use_sde": True},
    "network": {**QUICK["network"], "squash_output": True},
}


@pytest.mark.parametrize("changes", [{}, TIMED, SQUASHED], ids=["plain", "timed", "squashed"])
def test_the_student_does_what_the_teacher_does(tmp_path: Path, changes: dict[str, Any]) -> None:
    config = quick(**changes)
    result = train(config, tmp_path / "run")
    student, teacher = policies.make(f"learned:{result.policy}"), policies.make("fuzzy_expert")
    envs = CorridorVectorEnv(64, config.environments()[0])
    observations, _ = envs.reset(seed=5)
    misses, scale = [], []
    for _ in range(60):
        wanted, _ = teacher.predict(observations)
        misses.append(np.abs(student.predict(observations)[0] - wanted).mean())
        scale.append(np.abs(wanted.mean() - wanted).mean())
        observations, *_ = envs.step(wanted)
    assert np.mean(misses) < 0.3 * np.mean(scale)


def test_each_environment_has_its_own_teacher() -> None:
    env = ["Corridor-v1", "Crossing-v1"]
    teachers = {"Crossing-v1": "constant:fraction=0.25", "Corridor-v1": "constant:fraction=0.75"}
    config = quick(env=env, worlds=5, imitation={"teacher": teachers})
    envs = make_envs(config)
    actions, _ = teacher_of(config, envs).predict(envs.reset())
    first, _ = (part.num_envs for part in envs.unwrapped.parts)
    assert actions[:first, 0].tolist() == [0.5] * first
    assert actions[first:, 0].tolist() == [-0.5] * (5 - first)


@pytest.mark.parametrize("env", [["Corridor-v1"], ["Corridor-v1", "Crossing-v1", "Circle-v1"]])
def test_environments_without_a_teacher_or_teachers_without_an_environment_are_refused(
    env: list[str],
) -> None:
    teachers = dict.fromkeys(("Corridor-v1", "Crossing-v1"), "fuzzy_expert")
    with refused("imitation ... teacher ... Crossing-v1 ... one for each env"):
        quick(env=env, imitation={"teacher": teachers})


def test_equal_seeds_learn_equally(tmp_path: Path) -> None:
    weights = [
        train(quick(seed=seed), tmp_path / name).model.policy.state_dict()
        for name, seed in (("a", 3), ("b", 3), ("c", 4))
    ]
    first = "mlp_extractor.policy_net.0.weight"
    assert torch.equal(weights[0][first], weights[1][first])
    assert not torch.equal(weights[0][first], weights[2][first])


class Stands:
    """A student that does not move."""

    def predict(self, observation: Any, deterministic: bool) -> tuple[Any, None]:
        assert deterministic
        return np.full((len(observation), 1), -1.0, np.float32), None


def test_in_later_rounds_the_student_drives_and_the_teacher_answers() -> None:
    short = {"decisions": 400, "noise": 0.0, "teacher": "constant:fraction=1"}
    config = quick(worlds=4, overrides={"max_episode_steps": 50}, imitation=short)
    assert config.imitation
    envs = make_envs(config)
    rng, student = np.random.default_rng(0), cast(ActorCriticPolicy, Stands())
    seen = watch(envs, teacher_of(config, envs), config.imitation, 1.0, rng, student)
    speeds_mps = LAYOUTS["tracks"].decode(seen.observations)["speed_mps"]
    assert np.abs(speeds_mps).max() < 0.01
    assert (seen.actions == 1.0).all()


def test_further_rounds_are_learned_from_and_equal_seeds_learn_equally(tmp_path: Path) -> None:
    short = QUICK["imitation"] | {"epochs": 3}
    first = "mlp_extractor.policy_net.0.weight"
    a, b, c = (
        train(quick(imitation=short | {"rounds": rounds}), tmp_path / name).model.policy
        for name, rounds in (("a", 2), ("b", 2), ("c", 1))
    )
    assert torch.equal(a.state_dict()[first], b.state_dict()[first])
    assert not torch.equal(a.state_dict()[first], c.state_dict()[first])


def test_rounds_of_dagger_follow_from_its_steps() -> None:
    with refused("imitation ... rounds: given 3 ... 'dagger', allowed is 1"):
        load_training(algorithm="dagger", imitation={"rounds": 3})
