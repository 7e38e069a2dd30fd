"""A batch takes the place of single environments that make_vec_env would have made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor, load_results
from stable_baselines3.common.vec_env import VecEnv

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.sb3 import CorridorVecEnv
from tests.refusals import refused

ENCOUNTERING = "hazbot_gym/Encountering-v1"
SHORT: dict[str, Any] = {"place": "doorway", "config": {"max_episode_steps": 60}}


def pair(**arguments: Any) -> tuple[VecEnv, VecEnv]:
    """Return a batch and the single environments that the same call makes."""
    return (
        make_vec_env(ENCOUNTERING, 3, seed=5, vec_env_cls=CorridorVecEnv, **arguments),  # type: ignore[arg-type]
        make_vec_env(ENCOUNTERING, 3, seed=5, **arguments),
    )


def test_a_batch_does_what_the_single_environments_do() -> None:
    batch, loop = pair(env_kwargs=SHORT, monitor_kwargs={"info_keywords": ("outcome",)})
    assert isinstance(batch, CorridorVecEnv)
    assert batch.action_space.sample() == loop.action_space.sample()
    assert batch.reset() == pytest.approx(loop.reset(), abs=1e-6)
    episodes = 0
    for action in np.random.default_rng(0).uniform(-0.5, 1.0, (150, 3, 1)):
        (*one, infos), (*other, told) = batch.step(action), loop.step(action)
        for mine, others in zip(one, other, strict=True):
            assert mine == pytest.approx(others, abs=1e-5)
        for info, single in zip(infos, told, strict=True):
            assert ("episode" in info) == ("episode" in single)
            if "episode" in info:
                for name in ("r", "l"):
                    assert info["episode"][name] == pytest.approx(single["episode"][name], abs=1e-5)
                assert info["episode"]["outcome"] == single["episode"]["outcome"]
                episodes += 1
    assert episodes > 4


def test_the_horizon_and_id_are_those_of_the_single_environments() -> None:
    batch, loop = pair(env_kwargs={"max_episode_steps": 40})
    assert batch.get_attr("spec")[0].id == loop.get_attr("spec")[0].id == ENCOUNTERING
    assert batch.get_attr("config")[0].max_episode_steps == 40
    circle = make_vec_env("hazbot_gym/Circle-v1", 2, vec_env_cls=CorridorVecEnv)  # type: ignore[arg-type]
    assert circle.get_attr("spec")[0].max_episode_steps == 2000


def test_monitor_files_are_written(tmp_path: Path) -> None:
    folders = [tmp_path / "batch", tmp_path / "loop"]
    for folder, cls in zip(folders, (CorridorVecEnv, None), strict=True):
        envs = make_vec_env(  # type: ignore[arg-type]
            ENCOUNTERING, 3, 5, env_kwargs=SHORT, monitor_dir=str(folder), vec_env_cls=cls
        )
        envs.reset()
        for _ in range(130):
            envs.step(np.zeros((3, 1)))
        envs.close()
        envs.close()
    batch, loop = (load_results(str(folder)) for folder in folders)
    assert len(batch) == 6
    assert sorted(batch["l"]) == sorted(loop["l"])
    assert sorted(batch["r"]) == pytest.approx(sorted(loop["r"]), abs=1e-5)


def test_a_batch_made_so_counts_as_monitored() -> None:
    batch, loop = pair(env_kwargs=SHORT)
    assert batch.env_is_wrapped(Monitor) == loop.env_is_wrapped(Monitor) == [True] * 3
    model = PPO("MlpPolicy", batch, n_steps=64, batch_size=64, n_epochs=1, device="cpu").learn(192)
    assert len(model.ep_info_buffer or []) >= 3
    evaluate_policy(model, batch, n_eval_episodes=3)  # warns if it is not monitored


def test_the_batch_has_arguments_of_its_own() -> None:
    envs = make_vec_env(ENCOUNTERING, 2, vec_env_cls=CorridorVecEnv, vec_env_kwargs={"threads": 1})  # type: ignore[arg-type]
    assert envs.render_mode == "rgb_array"  # as make_vec_env asks of every environment
    assert CorridorVecEnv([CorridorEnv, CorridorEnv]).num_envs == 2


@pytest.mark.parametrize(
    ("functions", "complaint"),
    [
        ([], "num_envs ... no function"),
        ([lambda: gymnasium.make("CartPole-v1")], "num_envs ... a CartPoleEnv"),
        (
            [lambda: gymnasium.wrappers.ClipReward(CorridorEnv(), 0.0, 1.0)],
            "num_envs ... environments in ClipReward, allowed",
        ),
        (
            [CorridorEnv, lambda: CorridorEnv(tier="sonar")],
            "num_envs ... environments that differ",
        ),
        ([CorridorEnv, lambda: Monitor(CorridorEnv())], "num_envs ... some environments with"),
        (2.5, "num_envs ... 2.5"),
        ("ab", "num_envs ... 'ab'"),
    ],
)
def test_what_a_batch_cannot_stand_for_is_refused(functions: Any, complaint: str) -> None:
    with refused(complaint):
        CorridorVecEnv(functions)


def test_an_id_beside_functions_is_refused() -> None:
    with refused(f"id ... '{ENCOUNTERING}'"):
        CorridorVecEnv([CorridorEnv], id=ENCOUNTERING)
