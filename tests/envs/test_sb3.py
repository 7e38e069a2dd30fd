"""Stable-Baselines3 on the batched engine: its four-tuples, its wrappers, its learning."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.envs.registration import EnvSpec
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor, VecNormalize

from hazbot_gym.core.state import Floats
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.sb3 import CorridorVecEnv
from tests.refusals import refused

# Short episodes with contacts and timeouts.
LIVELY: dict[str, Any] = {
    "place": "doorway",
    "people": {"model": "scripted", "count": [2, 4]},
    "max_episode_steps": 90,
}
WORLDS, STEPS = 4, 200

torch.set_num_threads(1)  # the networks are too small to share among cores


def actions(seed: int = 0) -> Floats:
    """Return fast and slow driving (T, N, 1)."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(0.0, 1.0, (WORLDS, 1)) + rng.uniform(-1.0, 1.0, (STEPS, WORLDS, 1))
    return np.clip(drawn, -1.0, 1.0)


# --- the four-tuple ------------------------------------------------------------------------------


def test_a_step_returns_what_stable_baselines_expects() -> None:
    envs = CorridorVecEnv(WORLDS, seed=0, **LIVELY)
    assert envs.observation_space.contains(envs.reset()[0])
    for action in actions():
        observations, rewards, dones, infos = envs.step(action)
        assert observations.shape == (WORLDS, 51)
        assert observations.dtype == rewards.dtype == np.float32
        assert dones.dtype == np.bool_
        assert isinstance(infos, list)
        assert len(infos) == WORLDS
        for done, info in zip(dones, infos, strict=True):
            assert done == ("terminal_observation" in info) == (info["outcome"] != "running")


def test_every_world_does_what_its_single_environment_does() -> None:
    envs, drive, ends = CorridorVecEnv(WORLDS, seed=6, **LIVELY), actions(), []
    firsts, told = envs.reset(), [envs.step(action) for action in drive]
    for i in range(WORLDS):
        env = CorridorEnv(**LIVELY)
        observation, _ = env.reset(seed=6 + i)
        assert np.array_equal(firsts[i], observation)
        for action, (observations, rewards, dones, infos) in zip(drive[:, i], told, strict=True):
            observation, reward, terminated, truncated, info = env.step(action)
            assert rewards[i] == pytest.approx(reward, abs=1e-5)
            assert infos[i]["cost"] == pytest.approx(info["cost"])
            assert dones[i] == (terminated or truncated)
            if dones[i]:
                last = infos[i]
                assert last["terminal_observation"] == pytest.approx(observation, abs=1e-6)
                assert last["TimeLimit.truncated"] == truncated
                assert last["outcome"] == info["outcome"]
                assert last["reward_terms"] == pytest.approx(info["reward_terms"])
                ends.append(info["outcome"])
                observation, _ = env.reset()
            assert observations[i] == pytest.approx(observation, abs=1e-6)
    assert {"contact_person", "timeout"} <= set(ends)


@pytest.mark.parametrize("gas", [None, {"leak_share": 0.5}], ids=["", "gas"])
def test_infos_are_those_of_stable_baselines_own_loop(gas: Any) -> None:
    batch = CorridorVecEnv(WORLDS, **LIVELY, gas=gas)
    loop = DummyVecEnv(WORLDS * [lambda: CorridorEnv(**LIVELY, gas=gas)])
    ends = 0
    for envs in (batch, loop):
        envs.seed(6)
        envs.reset()
    assert_alike(batch.reset_infos, loop.reset_infos)
    for action in actions():
        (*_, dones, infos), (*_, told) = batch.step(action), loop.step(action)
        assert_alike(infos, told)
        assert_alike(batch.reset_infos, loop.reset_infos)
        ends += dones.sum()
    assert ends > 4


def assert_alike(infos: list[dict[str, Any]], others: list[dict[str, Any]]) -> None:
    """Check that infos are equal in keys, types and, but for rounding, values."""
    for info, other in zip(infos, others, strict=True):
        assert {key: type(value) for key, value in info.items()} == {
            key: type(value) for key, value in other.items()
        }
        for key, value in other.items():
            is_exact = isinstance(value, str | int)
            assert info[key] == (value if is_exact else pytest.approx(value, abs=1e-6)), key


def test_infos_that_are_changed_change_nothing_else() -> None:
    envs = CorridorVecEnv(2, seed=0, gas={})
    envs.reset()
    envs.reset_infos[0].clear()
    *_, infos = envs.step(np.zeros((2, 1)))
    expected = copy.deepcopy(infos[1])
    infos[0]["reward_terms"].clear()
    infos[0]["gas"].clear()
    infos[0].clear()
    assert infos[1] == expected
    assert set(envs.step(np.zeros((2, 1)))[-1][0]) == set(expected)


def test_reset_infos_tell_of_the_episode_that_runs_now() -> None:
    envs, env = CorridorVecEnv(2, seed=3, max_episode_steps=2), CorridorEnv()
    envs.reset()
    scenarios = [env.reset(seed=3)[1]["scenario_key"], env.reset()[1]["scenario_key"]]
    assert envs.reset_infos[0]["scenario_key"] == scenarios[0]
    for _ in range(2):
        envs.step(np.zeros((2, 1)))
    assert envs.reset_infos[0]["scenario_key"] == scenarios[1]
    assert envs.reset_infos[0]["place"] == "corridor"
    assert envs.reset_infos[0]["time_free_s"] == pytest.approx(env.reset()[1]["time_free_s"])


# --- the value of a truncated episode ------------------------------------------------------------


class Rewards(BaseCallback):
    """Notes what the environment itself paid, and how each step ended."""

    def __init__(self) -> None:
        super().__init__()
        self.paid: list[Any] = []
        self.infos: list[Any] = []

    def _on_step(self) -> bool:
        self.paid.append(self.locals["rewards"].copy())
        self.infos.append(self.locals["infos"])
        return True


def test_ppo_adds_the_value_of_the_last_observation_where_time_ran_out_only() -> None:
    model = PPO(
        "MlpPolicy",
        CorridorVecEnv(WORLDS, seed=1, **LIVELY),
        n_steps=STEPS,
        batch_size=STEPS,
        n_epochs=1,
        gamma=0.9,
        seed=0,
        device="cpu",
    )
    value = np.arange(51.0)
    weights = model.policy.obs_to_tensor(value)[0].flatten()
    model.policy.predict_values = lambda seen: (seen.double() @ weights.double()).reshape(-1, 1)
    told = Rewards()
    model.learn(STEPS * WORLDS, callback=told)
    truncated = terminated = 0
    for t, infos in enumerate(told.infos):
        for i, info in enumerate(infos):
            added = model.rollout_buffer.rewards[t, i] - told.paid[t][i]
            if info.get("TimeLimit.truncated"):
                assert info["outcome"] == "timeout"
                assert added == pytest.approx(0.9 * info["terminal_observation"] @ value, rel=1e-5)
                truncated += 1
            else:
                assert added == 0.0
                terminated += info["outcome"] != "running"
    assert truncated > 2
    assert terminated > 2


# --- wrappers and learning -----------------------------------------------------------------------


def test_monitored_episodes_agree_with_our_own_counts() -> None:
    envs = VecMonitor(CorridorVecEnv(WORLDS, seed=0, **LIVELY))
    envs.reset()
    returns, lengths, episodes = np.zeros(WORLDS), np.zeros(WORLDS, np.int64), 0
    for action in actions():
        _, rewards, dones, infos = envs.step(action)
        returns, lengths = returns + rewards, lengths + 1
        for i in np.flatnonzero(dones):
            assert infos[i]["episode"]["r"] == pytest.approx(returns[i], abs=1e-3)
            assert infos[i]["episode"]["l"] == lengths[i]
            returns[i], lengths[i], episodes = 0.0, 0, episodes + 1
    assert episodes > 4


def test_normalized_observations_go_along_with_the_last_ones() -> None:
    envs = VecNormalize(CorridorVecEnv(WORLDS, seed=0, **LIVELY))
    plain = CorridorVecEnv(WORLDS, seed=0, **LIVELY)
    envs.reset(), plain.reset()
    ends = 0
    for action in actions():
        observations, _, dones, infos = envs.step(action)
        raw, _, _, raw_infos = plain.step(action)
        assert observations == pytest.approx(envs.normalize_obs(raw), abs=1e-6)
        for i in np.flatnonzero(dones):
            last = envs.normalize_obs(raw_infos[i]["terminal_observation"])
            assert infos[i]["terminal_observation"] == pytest.approx(last, abs=1e-6)
            ends += 1
    assert ends > 4
    assert np.abs(envs.obs_rms.mean).max() > 0.1


def learn(algorithm: Any, steps: int, **options: Any) -> None:
    """Train for some steps, and check that what was learned drives."""
    envs = VecNormalize(VecMonitor(CorridorVecEnv(WORLDS, **LIVELY)))
    model = algorithm("MlpPolicy", envs, seed=0, device="cpu", **options)
    model.learn(steps)
    assert model.num_timesteps >= steps
    assert all(np.isfinite(p.detach().numpy()).all() for p in model.policy.parameters())
    fresh = VecMonitor(CorridorVecEnv(WORLDS, seed=9, **LIVELY))
    assert np.isfinite(evaluate_policy(model, fresh, n_eval_episodes=4)[0])


def test_ppo_and_sac_learn_for_a_moment() -> None:
    learn(PPO, 400, n_steps=50, batch_size=50, n_epochs=1)
    learn(SAC, 400, learning_starts=300)


def test_ppo_learns_with_discrete_actions() -> None:
    envs = CorridorVecEnv(WORLDS, action_type="discrete", **LIVELY)
    PPO("MlpPolicy", envs, n_steps=50, batch_size=50, device="cpu").learn(200)


@pytest.mark.long
@pytest.mark.parametrize("algorithm", [PPO, SAC])
def test_ppo_and_sac_learn_for_20000_steps(algorithm: Any) -> None:
    learn(algorithm, 20_000)


def test_the_same_seed_trains_the_same_model() -> None:
    one, other = (
        PPO("MlpPolicy", CorridorVecEnv(2, **LIVELY), n_steps=32, seed=5, device="cpu").learn(64)
        for _ in range(2)
    )
    for mine, others in zip(one.policy.parameters(), other.policy.parameters(), strict=True):
        assert np.array_equal(mine.detach().numpy(), others.detach().numpy())


# --- seeds, attributes, refusals -----------------------------------------------------------------


def test_a_seed_is_used_once_and_reproduces() -> None:
    envs = CorridorVecEnv(3)
    assert list(envs.seed(7)) == [7, 8, 9]
    assert all(isinstance(seed, int) for seed in CorridorVecEnv(3).seed(None))
    first, second = envs.reset(), envs.reset()
    assert not np.array_equal(first, second)
    envs.seed(7)
    assert np.array_equal(envs.reset(), first)
    assert np.array_equal(envs.reset(), second)
    assert np.array_equal(CorridorVecEnv(3, seed=7).reset(), first)


def test_a_pickled_batch_goes_on_alike() -> None:
    envs = CorridorVecEnv(WORLDS, seed=0, **LIVELY)
    envs.reset()
    for action in actions()[:50]:
        envs.step(action)
    twin = pickle.loads(pickle.dumps(envs))
    for action in actions()[50:]:
        (*one, _), (*other, _) = envs.step(action), twin.step(action)
        assert all(np.array_equal(mine, others) for mine, others in zip(one, other, strict=True))


def test_seeds_of_worlds_are_told_whether_given_or_not() -> None:
    envs = CorridorVecEnv(2)
    envs.reset()
    keys = [info["scenario_key"] for info in envs.reset_infos]
    again = CorridorVecEnv(2)
    again._seeds = envs.get_attr("np_random_seed")
    again.reset()
    assert [info["scenario_key"] for info in again.reset_infos] == keys
    envs.seed(5)
    envs.reset()
    envs.reset()
    assert envs.get_attr("np_random_seed") == [5, 6]
    with pytest.raises(IndexError):
        envs.get_attr("np_random_seed", 2)


@pytest.mark.parametrize("options", [3, "key", [1, 2], [{"key": 7}, None], [{}]], ids=str)
def test_options_that_are_none_are_refused(options: Any) -> None:
    with refused("reset options ... dict"):
        CorridorVecEnv(2).set_options(options)


@pytest.mark.parametrize("seed", ["abc", 1.5, -1])
def test_seed_that_is_none_is_refused(seed: Any) -> None:
    with refused("seed"):
        CorridorVecEnv(2, seed=seed)


def test_options_are_used_once_in_all_worlds_or_in_each() -> None:
    envs = CorridorVecEnv(3, seed=0)
    envs.set_options({"key": 7})
    envs.reset()
    assert [info["scenario_key"] for info in envs.reset_infos] == [7, 7, 7]
    envs.set_options([{"key": 1}, {}, {"key": 3}])
    envs.reset()
    keys = [info["scenario_key"] for info in envs.reset_infos]
    assert (keys[0], keys[2]) == (1, 3)
    assert keys[1] not in (1, 3, 7)
    envs.reset()
    assert not {info["scenario_key"] for info in envs.reset_infos} & {1, 3, 7, keys[1]}
    loop = DummyVecEnv([CorridorEnv])
    loop.set_options({"key": 7})
    envs.set_options({"key": 7})
    assert envs.reset()[0] == pytest.approx(loop.reset()[0], abs=1e-6)
    for bad, complaint in (
        ({"kye": 7}, "reset options ... kye ... key"),
        ({"key": -7}, "reset options ... key ... -7"),
    ):
        envs.set_options(bad)
        with refused(complaint):
            envs.reset()


def test_attributes_are_those_of_single_environments() -> None:
    envs, single = CorridorVecEnv(3, tier="sonar"), CorridorEnv(tier="sonar")
    assert envs.get_attr("num_envs") == [3, 3, 3]
    assert envs.get_attr("render_mode", [0, 2]) == [None, None]
    for name in ("observation_space", "action_space", "config", "metadata"):
        assert envs.get_attr(name, 1) == [getattr(single, name)]
    for name in ("action_masks", "reset", "state", "places"):
        assert not envs.has_attr(name)
    spec = envs.get_attr("spec")[0]
    again = gymnasium.make(EnvSpec.from_json(spec.to_json())).unwrapped
    assert (spec.id, again.config) == ("hazbot_gym/Corridor-v1", single.config)


def test_an_environment_is_named_by_its_id() -> None:
    envs = CorridorVecEnv(2, id="hazbot_gym/Circle-v1", tier="sonar", seed=5)
    env = gymnasium.make("hazbot_gym/Circle-v1", tier="sonar")
    assert envs.reset()[0] == pytest.approx(env.reset(seed=5)[0], abs=1e-6)
    assert envs.get_attr("config") == 2 * [env.unwrapped.config]
    assert envs.get_attr("spec")[0].id == "hazbot_gym/Circle-v1"
    unknown: list[Any] = ["hazbot_gym/Circus-v1", "CartPole-v1", "nowhere/X-v0", ["x"]]
    for bad in unknown:
        with refused(f"id: given {bad!r}"):
            CorridorVecEnv(2, id=bad)


def test_nothing_single_can_be_changed_or_called() -> None:
    envs = CorridorVecEnv(3)
    assert envs.env_is_wrapped(Monitor) == [False, False, False]
    with refused("set_attr ... 'config'"):
        envs.set_attr("config", None)
    with refused("env_method ... 'snapshot'"):
        envs.env_method("snapshot")
    envs.close()
    envs.close()


def test_bad_input_is_refused_in_one_line() -> None:
    envs = CorridorVecEnv(3)
    with refused("step ... no episode"):
        envs.step(np.zeros((3, 1)))
    envs.reset()
    with refused("actions ... (2, 1)"):
        envs.step(np.zeros((2, 1)))
    with refused("num_envs ... 0"):
        CorridorVecEnv(0)
