"""Additions of a run's environments to those of Stable-Baselines3, held to single environments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.task.reward import SURVEY
from hazbot_gym.training.config import TrainConfig
from hazbot_gym.training.vec_envs import make_envs
from tests.refusals import refused

LIVELY: dict[str, Any] = {"place": "doorway", "people": {"count": [2, 4]}, "max_episode_steps": 60}
WORLDS, STEPS = 5, 150


def made(**changes: Any) -> Any:
    values: dict[str, Any] = {"worlds": WORLDS, "overrides": LIVELY, **changes}
    return make_envs(TrainConfig.model_validate(values))


def actions() -> Any:
    return np.random.default_rng(0).uniform(-0.2, 1.0, (STEPS, WORLDS, 1)).astype(np.float32)


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
@pytest.mark.parametrize("env", [["hazbot_gym/Corridor-v1"], ["hazbot_gym/Corridor-v1"] * 2])
def test_every_world_does_and_sums_up_what_its_single_environment_does(
    engine: str, env: list[str]
) -> None:
    envs, ends = made(engine=engine, env=env, reward_scale=0.1), 0
    envs.seed(6)
    firsts, told = envs.reset(), [envs.step(action) for action in actions()]
    for i in range(WORLDS):
        single = CorridorEnv(**LIVELY)
        observation, start = single.reset(seed=6 + i)
        assert firsts[i] == pytest.approx(observation, abs=1e-6)
        total, cost, intrusion, length = 0.0, 0.0, 0.0, 0
        for action, (observations, rewards, dones, infos) in zip(actions(), told, strict=True):
            observation, reward, terminated, truncated, info = single.step(action[i])
            total, cost, length = total + reward, cost + info["cost"], length + 1
            intrusion += info["reward_terms"]["intrusion"]
            assert rewards[i] == pytest.approx(0.1 * reward, abs=1e-5)
            assert dones[i] == (terminated or truncated)
            if dones[i]:
                episode = infos[i]["episode"]
                assert episode["r"] == pytest.approx(total, abs=1e-3)
                assert episode["l"] == length
                assert episode["cost"] == pytest.approx(cost, abs=1e-6)
                assert episode["intrusion"] == pytest.approx(intrusion, abs=1e-6)
                ratio = length * 0.1 / start["time_free_s"]
                assert episode["time_ratio"] == pytest.approx(ratio)
                assert 0.0 < episode["speed_mps"] <= 0.5
                assert infos[i]["outcome"] == info["outcome"]
                observation, start = single.reset()
                total, cost, intrusion, length, ends = 0.0, 0.0, 0.0, 0, ends + 1
            assert observations[i] == pytest.approx(observation, abs=1e-6)
    assert ends > WORLDS
    envs.close()


@pytest.mark.parametrize("engine", ["batched", "pymunk"])
def test_episodes_in_gas_sum_up_the_survey(engine: str) -> None:
    gas = {"leak_share": 1.0, "strength_ppm": [200.0, 200.0]}
    envs = made(engine=engine, overrides={**LIVELY, "gas": gas})
    envs.seed(6)
    envs.reset()
    sums, ends = np.zeros(WORLDS), []
    for action in actions():
        *_, dones, infos = envs.step(action)
        sums += envs.unwrapped.terms[:, SURVEY]
        for i in np.flatnonzero(dones):
            survey = infos[i]["episode"]["survey"]
            assert survey == pytest.approx(sums[i])
            assert (survey > 0.0) == (infos[i]["gas"]["reported"] == 1)
            ends.append(survey)
        sums[dones] = 0.0
    assert {1.0, -1.0} <= set(ends)
    envs.close()


def test_environments_with_and_without_gas_do_not_share_the_worlds() -> None:
    with refused("env ... Corridor-v1 ... Inspection-v1 ... gas"):
        made(env=["hazbot_gym/Corridor-v1", "hazbot_gym/Inspection-v1"], overrides={})


def test_different_environments_share_the_worlds() -> None:
    env = ["hazbot_gym/Corridor-v1", "hazbot_gym/Circle-v1"]
    envs = made(env=env, overrides={})
    envs.reset()
    assert [part.num_envs for part in envs.parts] == [3, 2]
    places = [info["place"] for part in envs.unwrapped.parts for info in part.reset_infos]
    assert places == ["corridor"] * 3 + ["circle"] * 2


def test_observations_begin_where_torch_reads_them_alike() -> None:
    envs = made(worlds=3)
    for observations in [envs.reset()] + [envs.step(action[:3])[0] for action in actions()[:20]]:
        assert observations.ctypes.data % 64 == 0


def test_nothing_single_can_be_changed_or_called() -> None:
    envs = made()
    assert envs.get_attr("render_mode", [0, 4]) == [None, None]
    assert envs.env_is_wrapped(CorridorEnv) == [False] * WORLDS
    with refused("set_attr: given 'config'"):
        envs.set_attr("config", None)
    with refused("env_method: given 'snapshot'"):
        envs.env_method("snapshot")
