"""Write ``configs/rl_zoo3`` from ``configs/tuned``: ``python docs/make_rl_zoo3.py``.

rl-zoo3 steps a few single environments in a loop. So rollouts and updates per action stay as they
are in the training file, over fewer environments. It has no setting for shaping, the asymmetric
critic and staggered starts, which are left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from hazbot_gym.utils.files import write_text
from hazbot_gym.utils.yaml_loader import read_yaml

ROOT = Path(__file__).parents[1]
CONFIGS, WRITTEN = ROOT / "configs" / "tuned", ROOT / "configs" / "rl_zoo3"
# Training files by the name of the algorithm in rl-zoo3.
FILES = {
    "ppo": "ppo",
    "ppo_lstm": "recurrent_ppo",
    "sac": "sac",
    "td3": "td3",
    "tqc": "tqc",
    "crossq": "crossq",
    "qrdqn": "qrdqn",
}
ON_POLICY_ENVS, OFF_POLICY_ENVS = 16, 8
HEAD = """# Written by docs/make_rl_zoo3.py from configs/tuned/{file}.yaml; not tuned in rl-zoo3.
# Shaping, the asymmetric critic and staggered starts are missing.
"""


def settings(training: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of rl-zoo3 for the values of a training file."""
    options, network = dict(training["options"]), dict(training["network"])
    is_on_policy = "n_steps" in options
    envs = ON_POLICY_ENVS if is_on_policy else OFF_POLICY_ENVS
    scale = training["worlds"] / envs
    if is_on_policy:
        options["n_steps"] = round(options["n_steps"] * scale)
    else:
        options["gradient_steps"] = max(1, round(options["gradient_steps"] / scale))
    if "action_noise" in options:
        options |= {"noise_type": "normal", "noise_std": options.pop("action_noise")}
    return {
        "n_envs": envs,
        "n_timesteps": training["steps"],
        "env_wrapper": [{"rl_zoo3.wrappers.FrameSkip": {"skip": training["action_repeat"]}}],
        "policy": "MlpLstmPolicy" if "lstm_hidden_size" in network else "MlpPolicy",
        "learning_rate": f"lin_{training['learning_rate']}",
        **options,
        "policy_kwargs": _as_code(network),
    }


def _as_code(network: dict[str, Any]) -> str:
    """Return a network as rl-zoo3 has it, as Python."""
    activation = {"relu": "nn.ReLU", "tanh": "nn.Tanh"}[network.pop("activation")]
    others = [f"{name}={value!r}" for name, value in network.items()]
    return f"dict({', '.join([*others, f'activation_fn={activation}'])})"


def text(file: str) -> str:
    """Return the file of settings for a training file."""
    values = settings(read_yaml(CONFIGS / f"{file}.yaml"))
    return HEAD.format(file=file) + yaml.safe_dump({"default": values}, sort_keys=False)


if __name__ == "__main__":
    for algorithm, file in FILES.items():
        write_text(WRITTEN / f"{algorithm}.yml", text(file))
