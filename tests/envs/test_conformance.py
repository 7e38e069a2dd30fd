"""Conformance with Gymnasium's and Stable-Baselines3's checks of an environment, for every id."""

from __future__ import annotations

import copy
import pickle
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_for_sb3

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.registration import ENVIRONMENTS, NAMESPACE
from hazbot_gym.task.observation import layout_for

IDS = [f"{NAMESPACE}/{name}" for name in ENVIRONMENTS]
VARIANTS: list[dict[str, Any]] = [
    {"action_type": "discrete"},
    {"tier": "sonar"},
    {"tier": "privileged"},
    {"scenario": "C*"},
    {"people": {"model": "seeded"}},
    {"people": {"count": [0, 0]}},
]

everywhere = pytest.mark.parametrize("env_id", IDS)
varied = pytest.mark.parametrize("options", VARIANTS, ids=str)


def bare(env_id: str, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(env_id, **options).unwrapped


@everywhere
def test_gymnasium_finds_nothing_to_complain_about(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(bare(env_id, render_mode="rgb_array"))


@everywhere
def test_stable_baselines_finds_nothing_to_complain_about(env_id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env_for_sb3(bare(env_id), warn=True)


@varied
def test_neither_complains_about_a_variant(options: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(bare(IDS[0], **options), skip_render_check=True)
        check_env_for_sb3(bare(IDS[0], **options), warn=True)


@everywhere
def test_a_spec_survives_json_and_makes_the_same_environment(env_id: str) -> None:
    spec = gymnasium.make(env_id, tier="sonar", people={"count": [1, 2]}).spec
    assert spec is not None
    restored = EnvSpec.from_json(spec.to_json())
    assert restored == spec
    env = gymnasium.make(restored).unwrapped
    assert isinstance(env, CorridorEnv)
    assert env.config.people.count == (1, 2)
    sonar = layout_for("sonar", has_gas=env.config.gas is not None)
    assert env.observation_space.shape == (sonar.width,)


def test_an_environment_is_made_by_module_and_id() -> None:
    env = gymnasium.make(f"{NAMESPACE}:{IDS[0]}")
    assert isinstance(env.unwrapped, CorridorEnv)


@pytest.mark.parametrize("env_id", IDS[:2])
def test_a_synchronous_vector_environment_steps(env_id: str) -> None:
    envs = gymnasium.make_vec(env_id, num_envs=3, vectorization_mode="sync")
    singles = [gymnasium.make(env_id) for _ in range(3)]
    observations, _ = envs.reset(seed=[1, 2, 3])
    alone = [env.reset(seed=seed)[0] for env, seed in zip(singles, (1, 2, 3), strict=True)]
    assert observations.tolist() == np.stack(alone).tolist()
    actions = np.ones((3, 1), np.float32)
    observations, rewards, *_ = envs.step(actions)
    steps = [env.step(action) for env, action in zip(singles, actions, strict=True)]
    assert observations.tolist() == np.stack([step[0] for step in steps]).tolist()
    assert rewards.tolist() == [step[1] for step in steps]
    envs.close()


@everywhere
@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_where_the_original_stands(env_id: str, clone: Any) -> None:
    """Copies hold physics, sensors and random numbers of their own."""
    env = bare(env_id)
    env.reset(seed=4)
    for _ in range(20):
        env.step(np.array([0.5]))
    twin = clone(env)
    ahead = [follow(env, seed=9) for _ in range(2)]
    assert [follow(twin, seed=9) for _ in range(2)] == ahead


def follow(env: gymnasium.Env[Any, Any], seed: int) -> list[Any]:
    """Step to the end of the episode and reset; return everything that was seen."""
    rng = np.random.default_rng(seed)
    seen: list[Any] = []
    is_over = False
    while not is_over:
        observation, reward, terminated, truncated, info = env.step(rng.uniform(0.0, 1.0, 1))
        seen.append((observation.tolist(), reward, terminated, truncated, info))
        is_over = terminated or truncated
    seen.append(env.reset()[0].tolist())
    return seen
