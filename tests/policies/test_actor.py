"""Actors of plain arrays: by hand, and beside the models of Stable-Baselines3 they came from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium.wrappers import RescaleAction
from sb3_contrib import QRDQN, TQC, CrossQ, RecurrentPPO
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from hazbot_gym import policies
from hazbot_gym.policies.actor import Actor, Normalisation
from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.policies.layer import Layer
from hazbot_gym.policies.lstm import Lstm
from tests.refusals import refused


def layer(weight: Any, bias: Any) -> Layer:
    return Layer(np.array(weight, np.float32), np.array(bias, np.float32))


# --- by hand -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("activation", "head", "expected"),
    [
        ("tanh", "clipped", 2.0 * np.tanh(0.25) - 1.0),
        ("relu", "clipped", -0.5),
        ("relu", "squashed", np.tanh(-0.5)),
    ],
)
def test_one_hidden_unit_is_what_it_is_by_hand(activation: str, head: str, expected: float) -> None:
    actor = Actor((layer([[0.5], [0.0]], [0.0]), layer([[2.0]], [-1.0])), activation, head)
    assert actor.act([0.5, 9.0])[0] == pytest.approx([expected])
    assert actor.act(np.full((2, 3, 2), 0.5))[0].shape == (2, 3, 1)


def test_actions_end_at_stop_and_at_nominal_speed() -> None:
    actor = Actor((layer([[1.0]], [0.0]),), "tanh", "clipped")
    assert actor.act([[-5.0], [0.25], [5.0]])[0].tolist() == [[-1.0], [0.25], [1.0]]


def test_the_largest_value_names_a_level_of_speed() -> None:
    actor = Actor((layer([[1, 0, 0, 0, -1]], [0, 0, 0.5, 0, 0]),), "tanh", "levels")
    assert actor.act([[3.0], [0.0], [-3.0]])[0].tolist() == [[-1.0], [0.0], [1.0]]


def test_observations_are_normalised_and_clipped_first() -> None:
    statistics = Normalisation(np.float32([1.0]), np.float32([4.0]), clip=0.4, epsilon=0.0)
    actor = Actor((layer([[1.0]], [0.0]),), "tanh", "clipped", statistics)
    assert actor.act([[1.5], [9.0]])[0] == pytest.approx(np.array([[0.25], [0.4]]))


def test_what_is_observed_is_left_as_it_was() -> None:
    actor = Actor((layer(np.eye(3), [0, 0, 0]), layer([[1], [1], [1]], [0])), "tanh", "squashed")
    observation = np.ones((4, 3), np.float32)
    actor.act(observation)
    assert (observation == 1.0).all()


def test_a_memory_of_one_unit_is_what_it_is_by_hand() -> None:
    opened = 50.0  # a gate that lets everything through
    gates = layer([[0, 0, 1, 0], [0, 0, 0, 0]], [opened, opened, 0, opened])  # c <- c + tanh(x)
    actor = Actor((layer([[1.0]], [0.0]),), "tanh", "clipped", lstm=Lstm(gates))
    first, memory = actor.act([[0.3], [0.3]])
    second, memory = actor.act([[0.1], [0.1]], memory, np.array([False, True]))
    assert actor.width == 1
    assert first == pytest.approx(np.tanh(np.tanh(0.3)))
    expected = np.tanh([[np.tanh(0.3) + np.tanh(0.1)], [np.tanh(0.1)]])
    assert second == pytest.approx(expected)
    assert memory.hidden == pytest.approx(expected)


# --- beside torch --------------------------------------------------------------------------------


@pytest.mark.parametrize("activation", [torch.nn.Tanh, torch.nn.ReLU])
@pytest.mark.parametrize("algorithm", [PPO, SAC, TD3, TQC])
def test_actions_are_those_of_the_model(
    algorithm: Any, activation: Any, blank: Any, seen: Any
) -> None:
    model = algorithm(
        "MlpPolicy",
        blank(),
        seed=0,
        device="cpu",
        policy_kwargs={"net_arch": [64, 64], "activation_fn": activation},
    )
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.mul_(3.0)  # also beyond where actions are clipped
    expected, _ = model.predict(seen(), deterministic=True)
    assert actor_of(model).act(seen())[0] == pytest.approx(expected, abs=1e-5)
    assert np.std(expected) > 0.01


@pytest.mark.parametrize("is_squashed", [False, True])
@pytest.mark.parametrize("algorithm", [PPO, A2C])
def test_an_on_policy_actor_may_squash_its_mean(
    algorithm: Any, is_squashed: bool, blank: Any, seen: Any
) -> None:
    kwargs = {"net_arch": [64, 64], "squash_output": is_squashed}
    model = algorithm("MlpPolicy", blank(), seed=0, use_sde=True, policy_kwargs=kwargs)
    with torch.no_grad():
        model.policy.action_net.weight.mul_(100.0)  # which starts small
    expected, _ = model.predict(seen(), deterministic=True)
    assert actor_of(model).act(seen())[0] == pytest.approx(expected, abs=1e-5)
    assert np.std(expected) > 0.05


@pytest.mark.parametrize("algorithm", [SAC, TQC])
def test_noise_that_depends_on_the_state_has_no_plain_form_off_policy(
    algorithm: Any, blank: Any
) -> None:
    with refused("export ... use_sde=True ... False"):
        actor_of(algorithm("MlpPolicy", blank(), seed=0, device="cpu", use_sde=True))


def test_batch_normalizations_are_folded_into_layers(blank: Any, seen: Any) -> None:
    model = CrossQ("MlpPolicy", blank(), seed=0, device="cpu", policy_kwargs={"net_arch": [32, 32]})
    random = torch.Generator().manual_seed(0)
    with torch.no_grad():  # statistics and maps as if it had learned
        for name, values in model.policy.actor.state_dict().items():
            if values.dtype == torch.float32:
                drawn = torch.rand(values.shape, generator=random)
                values.copy_(drawn + 0.5 if name.endswith(("ra_var", "scale")) else drawn - 0.5)
    expected, _ = model.predict(seen(), deterministic=True)
    assert actor_of(model).act(seen())[0] == pytest.approx(expected, abs=1e-5)
    assert np.std(expected) > 0.01


def test_quantiles_are_averaged_into_the_last_layer(blank: Any, seen: Any) -> None:
    model = QRDQN(
        "MlpPolicy", blank(levels=5), seed=0, device="cpu",
        policy_kwargs={"net_arch": [32], "n_quantiles": 7},
    )  # fmt: skip
    expected, _ = model.predict(seen(), deterministic=True)
    actor = actor_of(model)
    assert actor.layers[-1].bias.shape == (5,)
    assert actor.act(seen())[0][:, 0] == pytest.approx(expected / 2.0 - 1.0)
    assert len(set(expected)) > 1


def test_a_recurrent_model_is_followed_through_episodes(blank: Any, seen: Any) -> None:
    model = RecurrentPPO(
        "MlpLstmPolicy",
        DummyVecEnv([lambda: blank("sonar")]),
        seed=0,
        device="cpu",
        policy_kwargs={"lstm_hidden_size": 24, "net_arch": [16]},
    )
    with torch.no_grad():
        for parameter in model.policy.parameters():
            parameter.mul_(3.0)
        model.policy.action_net.weight.mul_(30.0)  # which starts small
    actor, rng = actor_of(model), np.random.default_rng(1)
    states: list[Any] = [None, None]
    starts, answers = np.ones(500, np.bool_), []
    for _ in range(30):
        observations = rng.permutation(seen("sonar"))
        expected, states[0] = model.predict(observations, states[0], starts, deterministic=True)
        actions, states[1] = actor.act(observations, states[1], starts)
        assert actions == pytest.approx(expected, abs=1e-4)
        answers.append(actions)
        starts = rng.random(500) < 0.1
    assert np.std(answers) > 0.05
    model.policy.lstm_actor.num_layers = 2
    with refused("export ... LSTM ... 2 ... 1"):
        actor_of(model)


@pytest.mark.parametrize("algorithm", [PPO, DQN])
def test_levels_are_those_of_the_model(algorithm: Any, blank: Any, seen: Any) -> None:
    model = algorithm("MlpPolicy", blank("sonar", levels=5), seed=0, device="cpu")
    expected, _ = model.predict(seen("sonar"), deterministic=True)
    actions = actor_of(model).act(seen("sonar"))[0]
    assert actions[:, 0] == pytest.approx(expected / 2.0 - 1.0)
    assert len(set(expected.tolist())) > 1


def test_normalised_actions_are_those_of_the_model_behind_vecnormalize(
    blank: Any, seen: Any
) -> None:
    envs = VecNormalize(DummyVecEnv([blank]), clip_obs=2.0)
    envs.obs_rms.update(seen() * 0.5 + 0.2)
    model = PPO("MlpPolicy", envs, seed=0, device="cpu")
    raw = seen()
    expected, _ = model.predict(envs.normalize_obs(raw), deterministic=True)
    assert actor_of(model, envs).act(raw)[0] == pytest.approx(expected, abs=1e-5)
    assert actor_of(model).act(raw)[0] != pytest.approx(expected, abs=1e-2)


def test_what_has_no_plain_form_is_refused_in_one_line(blank: Any) -> None:
    odd = PPO("MlpPolicy", blank(), policy_kwargs={"activation_fn": torch.nn.ELU}, device="cpu")
    with refused("export ... elu ... tanh ... relu"):
        actor_of(odd)
    stranger = type("ARS", (), {"policy": None})()
    with refused("export ... ARS"):
        actor_of(stranger)
    own = {"features_extractor_class": type("Mine", (FlattenExtractor,), {})}
    with refused("export ... Mine"):
        actor_of(PPO("MlpPolicy", blank(), policy_kwargs=own, device="cpu"))


@pytest.mark.parametrize("algorithm", [PPO, SAC])
def test_actions_that_a_wrapper_has_changed_are_refused(
    algorithm: Any, blank: Any, tmp_path: Path
) -> None:
    model = algorithm("MlpPolicy", RescaleAction(blank(), np.float32(0), np.float32(1)))
    with refused("export ... Box(0.0, 1.0 ... from -1 to 1 or 5 levels"):
        actor_of(model)
    model.save(tmp_path / "model.zip")
    with refused("policy ... model.zip ... Box(0.0, 1.0 ... from -1 to 1 or 5 levels"):
        policies.make(f"learned:path={tmp_path / 'model.zip'}", allow_pickle=True)


def test_other_levels_than_those_of_the_environments_are_refused(blank: Any) -> None:
    with refused("export ... Discrete(3) ... 5 levels"):
        actor_of(DQN("MlpPolicy", blank("sonar", levels=3), device="cpu"))


@pytest.mark.parametrize("option", [{"bias": False}, {"proj_size": 4}])
def test_an_lstm_of_another_form_is_refused(option: dict[str, Any], blank: Any) -> None:
    kwargs = {"lstm_hidden_size": 8, "lstm_kwargs": option}
    model = RecurrentPPO("MlpLstmPolicy", blank(), device="cpu", policy_kwargs=kwargs)
    with refused("export ... lstm_kwargs"):
        actor_of(model)


def test_an_observation_is_answered_alike_alone_and_among_others() -> None:
    rng = np.random.default_rng(0)
    shapes = [(51, 96), (96, 96), (96, 1)]
    layers = tuple(
        Layer(rng.normal(0.0, 0.2, shape).astype(np.float32), np.zeros(shape[1], np.float32))
        for shape in shapes
    )
    actor = Actor(layers, "relu", "clipped")
    many = rng.uniform(-1.0, 1.0, (257, 51)).astype(np.float32)
    together = actor.act(many)[0]
    for count in (1, 3, 250):
        assert np.array_equal(actor.act(many[:count])[0], together[:count])
