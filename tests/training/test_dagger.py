"""DAgger: who drives in each round, what is kept, and that the student's error decreases."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from stable_baselines3.common.callbacks import CallbackList
from stable_baselines3.common.vec_env import VecEnvWrapper
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from hazbot_gym import policies
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.config import Imitation, TrainConfig, load_training
from hazbot_gym.training.logging import LEAST_STEPS
from hazbot_gym.training.run import train
from hazbot_gym.training.vec_envs import make_envs

RUN: dict[str, Any] = {
    "algorithm": "dagger",
    "worlds": 64,
    "steps": 3 * LEAST_STEPS,
    "overrides": {"max_episode_steps": 100},
    "imitation": {"decisions": LEAST_STEPS, "epochs": 6, "batch_size": 128, "noise": 0.0},
    "network": {"net_arch": [32], "activation": "relu"},
    "validation": {"every_steps": LEAST_STEPS, "episodes": 2},
}


def run(**changes: Any) -> TrainConfig:
    return load_training(None, **{**RUN, **changes})


class Spy(VecEnvWrapper):
    """Notes what the robots are told."""

    def reset(self) -> Any:
        self.told: list[Any] = []
        return self.venv.reset()

    def step_async(self, actions: Any) -> None:
        self.told.append(actions)
        self.venv.step_async(actions)

    def step_wait(self) -> Any:
        return self.venv.step_wait()


def shares(beta: float, rounds: int) -> list[float]:
    """Return the share of decisions that were the teacher's in each round."""
    torch.set_num_threads(1)
    config = run(worlds=16, options={"beta": beta}, imitation={"decisions": 800, "noise": 0.0})
    model: Any = make_model(config, Spy(make_envs(config)))  # type: ignore[arg-type]
    _, callback = model._setup_learn(1, CallbackList([]))
    found = []
    for model._n_updates in range(rounds):
        model.env.told.clear()
        demonstrations = model._drive(callback, np.random.default_rng(0))
        told = np.concatenate(model.env.told)
        found.append(float((told == demonstrations.actions.numpy()).mean()))
    return found


def test_the_teacher_drives_less_and_less() -> None:
    first, second, third = shares(0.5, rounds=3)
    assert first == 1.0
    assert second == pytest.approx(0.5, abs=0.1)
    assert third == pytest.approx(0.25, abs=0.1)
    assert shares(0.0, rounds=2) == pytest.approx([1.0, 0.0], abs=0.1)


@pytest.mark.parametrize("algorithm", ["bc", "dagger"])
def test_the_student_misses_less_and_less(algorithm: str, tmp_path: Path) -> None:
    result = train(run(algorithm=algorithm), tmp_path / "run")
    curves = EventAccumulator(str(tmp_path / "run" / "tensorboard")).Reload()
    misses = [event.value for event in curves.Scalars("imitation/miss")]
    assert misses[-1] < 0.3 * misses[0]
    model: Any = result.model
    assert len(model.observations) == len(model.actions) == model.num_timesteps
    seen = model.observations[::7].numpy()
    trained, _ = model.predict(seen, deterministic=True)
    wanted = model.actions[::7].numpy()
    assert np.abs(trained - wanted).mean() < 0.3 * np.abs(wanted.mean() - wanted).mean()
    best: Any = policies.make(f"learned:{result.policy}")
    assert best._policy.about["algorithm"] == {"bc": "BC", "dagger": "DAgger"}[algorithm]


def test_what_is_exported_drives_as_the_pupil(tmp_path: Path) -> None:
    config = run(steps=LEAST_STEPS)  # one round, so the best is the last
    result = train(config, tmp_path / "run")
    seen = result.model.observations[::7].numpy()  # type: ignore[attr-defined]
    trained, _ = result.model.predict(seen, deterministic=True)
    assert policies.make(f"learned:{result.policy}").predict(seen)[0] == pytest.approx(
        trained, abs=1e-5
    )


def test_a_teacher_is_there_unless_one_is_named() -> None:
    assert load_training(algorithm="bc").imitation == Imitation()
    assert load_training(algorithm="ppo").imitation is None
