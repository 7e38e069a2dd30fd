"""RL algorithms of a training run: registry and construction.

Stable-Baselines3's PPO, SAC (Haarnoja et al. 2018), TD3 (Fujimoto et al. 2018), DQN (Mnih et al.
2015); of its contrib package recurrent PPO, TQC, which truncates the critics' largest quantiles
against overestimation (Kuznetsov et al., ICML 2020), CrossQ, whose batch normalization replaces
target networks (Bhatt et al., ICLR 2024), and QR-DQN, whose critic predicts quantiles (Dabney et
al., AAAI 2018); and our own in ``dagger`` and ``ppo_lagrangian``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import sb3_contrib
import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.noise import NormalActionNoise
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env import VecEnv

from hazbot_gym.errors import InvalidInput
from hazbot_gym.policies.base import NO_CODE, Permissions
from hazbot_gym.policies.from_sb3 import actor_of
from hazbot_gym.task.observation import layout_in
from hazbot_gym.training.array_ppo import ArrayPPO
from hazbot_gym.training.asymmetric_critic import AsymmetricCriticPolicy
from hazbot_gym.training.config import STUDENTS, TrainConfig, hidden_entries
from hazbot_gym.training.dagger import BC, DAgger
from hazbot_gym.training.feature_mask import FeatureMask
from hazbot_gym.training.imitation import teacher_of
from hazbot_gym.training.options import MOST, check_options
from hazbot_gym.training.ppo_lagrangian import PPOLagrangian
from hazbot_gym.utils.json_object import JsonObject

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {
    "ppo": ArrayPPO,
    "sac": stable_baselines3.SAC,
    "td3": stable_baselines3.TD3,
    "tqc": sb3_contrib.TQC,
    "crossq": sb3_contrib.CrossQ,
    "dqn": stable_baselines3.DQN,
    "qrdqn": sb3_contrib.QRDQN,
    "recurrent_ppo": sb3_contrib.RecurrentPPO,
    "bc": BC,
    "dagger": DAgger,
}
ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}


def make_model(config: TrainConfig, envs: VecEnv, allowed: Permissions = NO_CODE) -> BaseAlgorithm:
    """Make a new model of a run; ``allowed`` holds the permissions of its teacher.

    Raises:
        InvalidInput: The algorithm does not accept these options or environments.
    """
    kind = PPOLagrangian if config.lagrangian else ALGORITHMS[config.algorithm]
    _check_options(config, kind)
    network = _feature_mask(config) | config.network
    activation = network.pop("activation", "tanh")
    if not isinstance(activation, str) or activation not in ACTIVATIONS:
        raise InvalidInput(
            f"network.activation: given {activation!r}, allowed are {', '.join(ACTIVATIONS)}"
        )
    options = _options(config, envs, allowed)
    try:
        model: BaseAlgorithm = kind(
            _policy_of(config),
            envs,
            learning_rate=LinearSchedule(config.learning_rate, config.final_learning_rate, 1.0),
            policy_kwargs={**network, "activation_fn": ACTIVATIONS[activation]},
            seed=config.seed,
            device="cpu",
            **options,
        )
    except (TypeError, ValueError, AssertionError, RuntimeError, MemoryError) as error:
        reason = str(error).split("__init__() ")[-1]
        raise InvalidInput(f"options: {config.algorithm} cannot use them: {reason}") from error
    actor_of(model)  # what cannot be exported later is refused now
    if isinstance(model, ArrayPPO):
        model.threads = config.threads
    if config.residual:
        _silence(model)
    return model


def _check_options(config: TrainConfig, kind: type[BaseAlgorithm]) -> None:
    check_options(config.options, kind, "options")
    update = config.options.get("n_steps", 1) * config.worlds
    if update > MOST:
        raise InvalidInput(
            f"options.n_steps: {update:,} decisions of {config.worlds} worlds, allowed are {MOST:,}"
        )
    policy = _policy_of(config)
    policy = kind.policy_aliases[policy] if isinstance(policy, str) else policy
    network = {name: value for name, value in config.network.items() if name != "activation"}
    check_options(network, policy, "network")


def _feature_mask(config: TrainConfig) -> JsonObject:
    """Return the policy options of the feature mask."""
    if not config.hidden:
        return {}
    hidden = hidden_entries(config.hidden, layout_in(config.environments()[0]))
    return {
        "features_extractor_class": FeatureMask,
        "features_extractor_kwargs": {"hidden": hidden},
    }


def _policy_of(config: TrainConfig) -> str | type[BasePolicy]:
    if config.asymmetric_critic:
        return AsymmetricCriticPolicy
    return "MlpLstmPolicy" if config.algorithm == "recurrent_ppo" else "MlpPolicy"


def _options(config: TrainConfig, envs: VecEnv, allowed: Permissions) -> JsonObject:
    """Return a file's options in the algorithm's format, with extra arguments of our own ones."""
    options = dict(config.options)
    if "action_noise" in options:  # its standard deviation; SB3 expects one value per action
        deviation = np.full(1, options["action_noise"], np.float32)
        options["action_noise"] = NormalActionNoise(np.zeros(1, np.float32), deviation)
    if config.algorithm in STUDENTS:
        assert config.imitation is not None
        options["teacher"] = teacher_of(config, envs, allowed)
        options["imitation"] = config.imitation
    if config.lagrangian:
        options["lagrangian"] = config.lagrangian
        options["reward_scale"] = config.reward_scale
    return options


def _silence(model: Any) -> None:
    """Zero an actor's output layer, so that a residual policy starts as its base."""
    with torch.no_grad():
        for parameter in model.policy.action_net.parameters():
            parameter.zero_()
