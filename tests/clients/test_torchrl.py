"""TorchRL reads the native batch, whether or not it resets by itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.numeric_info import NumericInfo
from hazbot_gym.envs.vector import CorridorVectorEnv

envs = pytest.importorskip("torchrl.envs")

pytestmark = [pytest.mark.clients, pytest.mark.slow, pytest.mark.filterwarnings("default")]

MODE = AutoresetMode.SAME_STEP
HORIZON = 20


def native() -> Any:
    return CorridorVectorEnv(2, autoreset_mode=MODE, max_episode_steps=HORIZON)


def sync() -> Any:
    return SyncVectorEnv(2 * [lambda: CorridorEnv(max_episode_steps=HORIZON)], autoreset_mode=MODE)


@pytest.mark.parametrize("make", [native, sync])
def test_a_batch_resets_in_the_same_step(make: Callable[[], Any]) -> None:
    told = envs.GymWrapper(NumericInfo(make())).rollout(60, break_when_any_done=False)
    assert told["next", "done"].sum() == 6
    assert told["next", "time_s"][0, 17:22].tolist() == pytest.approx([1.8, 1.9, 2.0, 0.1, 0.2])


def test_a_batch_does_not_reset_by_itself() -> None:
    made = gymnasium.make_vec(
        "hazbot_gym/Corridor-v1", 2, "vector_entry_point", autoreset_mode="Disabled",
        max_episode_steps=HORIZON,
    )  # fmt: skip
    told = envs.GymWrapper(made).rollout(60, break_when_any_done=False)
    assert told["next", "done"].sum() == 6


def test_gym_env_makes_a_single_environment() -> None:
    env = envs.GymEnv("hazbot_gym/Corridor-v1", max_episode_steps=HORIZON)
    envs.check_env_specs(env)
    assert env.rollout(60)["next", "truncated"].sum() == 1
