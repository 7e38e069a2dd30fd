"""Options of training files against the constructors of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import pytest

from hazbot_gym.training.options import check_options
from tests.refusals import refused

algorithms = pytest.importorskip("hazbot_gym.training.algorithms")


@pytest.mark.parametrize(
    ("algorithm", "options", "complaint"),
    [
        (
            "ppo",
            {"ent_coef": "1e-3"},
            "options.ent_coef: given '1e-3', input should be a valid num",
        ),
        ("ppo", {"n_steps": 32.0}, "options.n_steps: given 32.0, input should be a valid integer"),
        ("ppo", {"n_steps": True}, "options.n_steps: given True, input should be a valid integer"),
        ("ppo", {"n_steps": None}, "options.n_steps: given None, input should be a valid integer"),
        ("ppo", {"n_steps": 0}, "options.n_steps: given 0, allowed is 1 to 10,000,000"),
        (
            "ppo",
            {"n_stepz": 32},
            "options.n_stepz: unknown key, allowed are batch_size, clip_range",
        ),
        ("ppo", {"seed": 3}, "options.seed: unknown key, allowed are"),
        ("ppo", {"policy_kwargs": {}}, "options.policy_kwargs: unknown key, allowed are"),
        ("ppo", {"gamma": 1.5}, "options.gamma: given 1.5, allowed is 0 to 1"),
        ("ppo", {"gamma": float("nan")}, "options.gamma: given nan, input should be a finite"),
        ("ppo", {"normalize_advantage": "no"}, "options.normalize_advantage: given 'no', input"),
        ("ppo", {"target_kl": [0.1]}, "options.target_kl: given ... input should be a valid num"),
        ("sac", {"buffer_size": 10**12}, "options.buffer_size: given 1000000000000, allowed is 1"),
        ("td3", {"action_noise": "0.1"}, "options.action_noise: given '0.1', input should be"),
        ("dqn", {"train_freq": [1, 2]}, "options.train_freq: given ... input should be"),
        ("dagger", {"beta": 2.0}, "options.beta: given 2.0, allowed is 0 to 1"),
    ],
)
def test_bad_option_is_one_line_that_names_it(
    algorithm: str, options: dict[str, Any], complaint: str
) -> None:
    with refused(complaint):
        check_options(options, algorithms.ALGORITHMS[algorithm], "options")


@pytest.mark.parametrize(
    ("network", "complaint"),
    [
        ({"net_arch": "64"}, "network.net_arch: given '64', input should be"),
        ({"net_arch": [64, 0]}, "network.net_arch: given 0, allowed is 1 to"),
        ({"net_arch": [10**6, 10**6]}, "network.net_arch: given 1000000, allowed is 1 to 8,192"),
        ({"net_arch": [64, 64.0]}, "network.net_arch: given ... input should be a valid integer"),
        ({"net_arch": {"pi": [64], "vf": ["64"]}}, "network.net_arch: given ... input should be"),
        ({"log_std_init": "-2"}, "network.log_std_init: given '-2', input should be a valid num"),
        ({"lr_schedule": 1}, "network.lr_schedule: unknown key, allowed are"),
        ({"net": [64]}, "network.net: unknown key, allowed are full_std, log_std_init, net_arch"),
    ],
)
def test_bad_network_is_one_line_that_names_it(network: dict[str, Any], complaint: str) -> None:
    kind = algorithms.ALGORITHMS["ppo"].policy_aliases["MlpPolicy"]
    with refused(complaint):
        check_options(network, kind, "network")


@pytest.mark.parametrize(
    ("algorithm", "options"),
    [
        ("ppo", {"ent_coef": 0, "gamma": 1, "target_kl": None, "n_steps": 32, "clip_range": 0.1}),
        ("sac", {"ent_coef": "auto", "train_freq": [1, "step"], "gradient_steps": -1, "tau": 1.0}),
        ("td3", {"action_noise": 0.1, "learning_starts": 0}),
        ("tqc", {"top_quantiles_to_drop_per_net": 0}),
        ("recurrent_ppo", {"batch_size": None}),
        ("dagger", {"beta": 0.5}),
    ],
)
def test_what_the_algorithms_take_passes(algorithm: str, options: dict[str, Any]) -> None:
    check_options(options, algorithms.ALGORITHMS[algorithm], "options")
