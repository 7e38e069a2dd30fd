"""Validation of a training file's options against the constructors' signatures.

Stable-Baselines3 checks few options: a wrong type fails after the first rollout or changes the
training silently.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from hazbot_gym.errors import InvalidInput

# Set by the run itself, or not expressible in a file.
OURS = {
    "self", "policy", "env", "learning_rate", "policy_kwargs", "seed", "device", "lagrangian",
    "reward_scale", "teacher", "imitation", "tensorboard_log", "monitor_wrapper",
    "support_multi_env", "supported_action_spaces", "observation_space", "action_space",
    "lr_schedule", "activation_fn", "features_extractor_class", "features_extractor_kwargs",
    "optimizer_class", "replay_buffer_class", "rollout_buffer_class", "_init_setup_model",
}  # fmt: skip
SHARES = {"gamma", "gae_lambda", "tau", "clip_range", "exploration_fraction", "beta"}  # 0 to 1
# The minimum is 1 for counts and 0 otherwise, except for:
LEAST = {
    "gradient_steps": -1, "sde_sample_freq": -1, "learning_starts": 0, "verbose": 0,
    "top_quantiles_to_drop_per_net": 0, "log_std_init": -100, "final_log_std": -100,
    "target_entropy": -1000,
}  # fmt: skip
MOST = 10_000_000  # maximum of all numbers; a replay buffer of this size takes gigabytes
MOST_UNITS = 8192  # units of a layer; two such layers have 67 million weights
UNITS = {"net_arch", "lstm_hidden_size"}


def check_options(options: Mapping[str, object], kind: type, what: str) -> None:
    """Reject options that a class's constructor does not accept.

    Args:
        options: Options of a file.
        kind: The class.
        what: Name of the config field.

    Raises:
        InvalidInput: A name is unknown, or a value has another type or an impossible size.
    """
    known = {each.name: each for each in _parameters(kind) if each.name not in OURS}
    for name, value in options.items():
        if name not in known:
            allowed = ", ".join(sorted(known))
            raise InvalidInput(f"{what}.{name}: unknown key, allowed are {allowed}")
        kinds = float if name == "action_noise" else known[name].annotation
        _check_type(value, kinds, f"{what}.{name}")
        if not name.endswith("_kwargs"):
            _check_size(value, name, f"{what}.{name}", counts="float" not in str(kinds))


def _parameters(kind: type) -> Iterator[inspect.Parameter]:
    """Yield the arguments of a constructor, and those passed on to its base class."""
    for each in kind.__mro__:
        if "__init__" not in vars(each):
            continue
        made = vars(each)["__init__"]
        parameters = inspect.signature(made, eval_str=True).parameters.values()
        named = [p for p in parameters if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
        yield from named
        if len(named) == len(parameters):
            return


def _check_type(value: object, annotation: Any, field: str) -> None:
    # JSON mode accepts a list for a tuple, while numbers stay strict.
    config = ConfigDict(strict=True, arbitrary_types_allowed=True, allow_inf_nan=False)
    try:
        TypeAdapter(annotation, config=config).validate_json(json.dumps(value))
    except ValidationError as error:
        # Without the alternatives of a union, and with the original value.
        reason = max(error.errors(), key=lambda each: len(each["loc"]))["msg"]
        raise InvalidInput(f"{field}: given {value!r}, {reason[0].lower()}{reason[1:]}") from error


def _check_size(value: object, name: str, field: str, *, counts: bool) -> None:
    if isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            _check_size(each, name, field, counts=counts)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        least, most = LEAST.get(name, int(counts)), 1 if name in SHARES else MOST
        most = MOST_UNITS if name in UNITS else most
        if not least <= value <= most:
            raise InvalidInput(f"{field}: given {value}, allowed is {least} to {most:,}")
