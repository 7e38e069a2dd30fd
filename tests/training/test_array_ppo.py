"""PPO on arrays: the updates and rollouts of Stable-Baselines3's PPO, whatever the threads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure

from hazbot_gym.errors import InvalidInput
from hazbot_gym.training.algorithms import make_model
from hazbot_gym.training.array_ppo import CHUNK, ArrayPPO
from hazbot_gym.training.config import TrainConfig, load_training
from hazbot_gym.training.vec_envs import make_envs

SMALL: dict[str, Any] = {
    "env": "hazbot_gym/Crossing-v1",
    "worlds": 48,
    "overrides": {"max_episode_steps": 30},
    "options": {"n_steps": 64, "batch_size": 3072, "n_epochs": 2, "ent_coef": 0.01},
}


def small(**changes: Any) -> TrainConfig:
    return load_training(None, **{**SMALL, **changes})


def model_of(config: TrainConfig) -> Any:
    model: Any = make_model(config, make_envs(config))
    model.set_logger(configure(None, []))
    return model


def theirs(config: TrainConfig) -> PPO:
    """Return a model of Stable-Baselines3 with the same weights and environments."""
    ours = model_of(config)
    model = PPO(
        ours.policy_class, ours.get_env(), learning_rate=ours.learning_rate,
        policy_kwargs=ours.policy_kwargs, seed=config.seed, device="cpu", **config.options,
    )  # fmt: skip
    model.policy.load_state_dict(ours.policy.state_dict())
    model.set_logger(configure(None, []))
    return model


def collected(model: Any, seed: int = 3) -> Any:
    """Collect one rollout from fresh episodes; return the buffer."""
    _, callback = model._setup_learn(10_000, None)
    model.set_random_seed(seed)
    model._last_obs = model.get_env().reset()
    model._last_episode_starts = np.ones(model.n_envs, np.bool_)
    model.collect_rollouts(model.get_env(), callback, model.rollout_buffer, model.n_steps)
    return model.rollout_buffer


@pytest.mark.parametrize(
    "changes",
    [{}, {"asymmetric_critic": True, "shaping": "free_drive"}, {"hidden": ["person*"]}],
    ids=["plain", "asymmetric", "masked"],
)
def test_a_rollout_is_the_one_of_stable_baselines3(changes: dict[str, Any]) -> None:
    config = small(**changes)
    ours, other = collected(model_of(config)), collected(theirs(config))
    for name in ("observations", "actions", "rewards", "episode_starts", "values", "log_probs"):
        np.testing.assert_allclose(getattr(ours, name), getattr(other, name), atol=2e-5)
    np.testing.assert_allclose(ours.advantages, other.advantages, atol=2e-4)
    assert ours.episode_starts[1:].any()  # an episode ended within


def test_an_episode_cut_off_by_the_horizon_is_bootstrapped() -> None:
    model = model_of(small())
    rewards = collected(model).rewards.copy()
    assert model.rollout_buffer.episode_starts[30].sum() > 24  # most, after 30 decisions
    model.gamma = 0.0
    differs = collected(model).rewards != rewards
    assert differs[29].sum() > 24
    assert not differs[:20].any()


def test_an_update_is_the_one_of_stable_baselines3() -> None:
    config = small(options={**SMALL["options"], "n_epochs": 1})  # one minibatch: order is no matter
    ours, other = model_of(config), theirs(config)
    for model in (ours, other):
        collected(model).advantages[:] += 1.0  # the same rollout, up to rounding
        model.train()
    before = model_of(config).policy.state_dict()
    for name, weights in ours.policy.state_dict().items():
        expected = other.policy.state_dict()[name]
        torch.testing.assert_close(weights, expected, atol=2e-5, rtol=0.0)
        assert not torch.equal(weights, before[name])
    logged, others = ours.logger.name_to_value, other.logger.name_to_value
    assert logged.keys() == others.keys()
    for name, value in others.items():
        assert logged[name] == pytest.approx(value, rel=1e-3, abs=1e-5), name


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    assert SMALL["options"]["batch_size"] > CHUNK  # more than one chunk
    found = []
    for threads in (1, 2, 3):
        model = model_of(small(threads=threads))
        assert model.threads == threads
        collected(model)
        model.train()
        found.append(model.policy.state_dict())
    for other in found[1:]:
        assert all(torch.equal(weights, other[name]) for name, weights in found[0].items())


def test_discrete_actions_use_the_methods_of_stable_baselines3() -> None:
    model = model_of(small(overrides={"action_type": "discrete", "max_episode_steps": 30}))
    assert isinstance(model, ArrayPPO)
    collected(model)
    model.train()
    assert np.isfinite(model.logger.name_to_value["train/loss"])


def test_an_update_ends_beyond_the_target_divergence() -> None:
    model = model_of(small(options={**SMALL["options"], "n_epochs": 50, "target_kl": 1e-6}))
    collected(model)
    model.train()
    assert model._n_updates < 50


def test_the_learning_rate_follows_the_divergence() -> None:
    rates = {}
    for desired in (1e-8, 1e3):
        model = model_of(small(options={**SMALL["options"], "desired_kl": desired}))
        collected(model)
        model.train()
        rates[desired] = model.policy.optimizer.param_groups[0]["lr"]
        assert model.logger.name_to_value["train/learning_rate"] == rates[desired]
    assert rates[1e-8] < 1e-3 < rates[1e3]


OWN: tuple[dict[str, Any], ...] = (
    {"desired_kl": 0.01},
    {"final_log_std": -2.0},
    {"normalize_by_env": True},
)
DISCRETE = {"overrides": {"action_type": "discrete"}}


@pytest.mark.parametrize(
    ("given", "others", "changes"),
    [
        *((given, {}, DISCRETE) for given in OWN),
        *((given, {"use_sde": True}, {}) for given in OWN),
        *((given, {}, {"network": {"share_features_extractor": False}}) for given in OWN),
        ({"final_log_std": 0.0}, {}, DISCRETE),  # 0 is a value
        (OWN[0], {"clip_range_vf": 0.2}, {}),
    ],
    ids=str,
)
def test_an_option_without_effect_is_refused(
    given: dict[str, Any], others: dict[str, Any], changes: dict[str, Any]
) -> None:
    (name,) = given
    options = {**SMALL["options"], **given, **others}
    with pytest.raises(InvalidInput, match=f"^options: ppo cannot use them: {name} is given"):
        model_of(small(options=options, **changes))


def test_the_standard_deviation_falls_as_scheduled() -> None:
    options = {**SMALL["options"], "final_log_std": -2.0}
    model = model_of(small(options=options, network={"log_std_init": -1.0}))
    before = model.policy.action_net.weight.detach().clone()
    for remaining in (1.0, 0.25):
        model._setup_learn(10_000, None)
        model._current_progress_remaining = remaining
        _, callback = model._setup_learn(10_000, None)
        model.collect_rollouts(model.get_env(), callback, model.rollout_buffer, model.n_steps)
        model.train()
        expected = -2.0 + remaining
        assert model.policy.log_std.item() == pytest.approx(expected)
    assert not torch.equal(model.policy.action_net.weight, before)


def test_advantages_are_normalized_within_each_environment() -> None:
    env = ["Crossing-v1", "Corridor-v1"]
    plain = collected(model_of(small(env=env)))
    options = {**SMALL["options"], "normalize_by_env": True}
    own = collected(model_of(small(env=env, options=options)))
    assert np.array_equal(own.returns, plain.returns)
    for worlds in (slice(0, 24), slice(24, 48)):
        advantages = plain.advantages[:, worlds]
        expected = (advantages - advantages.mean()) / advantages.std()
        assert own.advantages[:, worlds] == pytest.approx(expected, abs=1e-4)
