"""The options of a training file, held to the constructors that they go to.

Stable-Baselines3 checks few of them: a wrong type breaks after the first rollout or changes what is
learned without a word.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from hazbot_gym.errors import InvalidInput

# What a run decides itself, or what no file can hold.
OURS = {
    "self", "policy", "env", "learning_rate", "policy_kwargs", "seed", "device", "lagrangian",
    "teacher", "imitation", "tensorboard_log", "monitor_wrapper", "support_multi_env",
    "supported_action_spaces", "observation_space", "action_space", "lr_schedule", "activation_fn",
    "features_extractor_class", "features_extractor_kwargs", "optimizer_class",
    "replay_buffer_class", "rollout_buffer_class", "_init_setup_model",
}  # fmt: skip
SHARES = {"gamma", "gae_lambda", "tau", "clip_range", "exploration_fraction", "beta"}  # 0 to 1
# The least of numbers is 1 for those that count something and else 0, but for:
LEAST = {
    "gradient_steps": -1, "sde_sample_freq": -1, "learning_starts": 0, "verbose": 0,
    "top_quantiles_to_drop_per_net": 0, "log_std_init": -100, "target_entropy": -1000,
}  # fmt: skip
MOST = 10_000_000  # of every number; a replay buffer of as many entries takes gigabytes
MOST_UNITS = 8192  # of a layer; two of them have 67 million weights between them
UNITS = {"net_arch", "lstm_hidden_size"}


def check_options(options: Mapping[str, Any], kind: type, what: str) -> None:
    """Refuse what the constructor of a class does not take.

    Args:
        options: As a file gives them.
        kind: The class that they go to.
        what: The field that they stand in.

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
    """Yield the arguments of a constructor, and those that it passes on to the one below it."""
    for each in kind.__mro__:
        if "__init__" not in vars(each):
            continue
        made = vars(each)["__init__"]
        parameters = inspect.signature(made, eval_str=True).parameters.values()
        named = [p for p in parameters if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)]
        yield from named
        if len(named) == len(parameters):
            return


def _check_type(value: Any, annotation: Any, field: str) -> None:
    # As JSON, a list will do for a tuple, while numbers stay strict.
    config = ConfigDict(strict=True, arbitrary_types_allowed=True, allow_inf_nan=False)
    try:
        TypeAdapter(annotation, config=config).validate_json(json.dumps(value))
    except ValidationError as error:
        # Without the alternatives of a union, and with the value as the file has it.
        reason = max(error.errors(), key=lambda each: len(each["loc"]))["msg"]
        raise InvalidInput(f"{field}: given {value!r}, {reason[0].lower()}{reason[1:]}") from error


def _check_size(value: Any, name: str, field: str, *, counts: bool) -> None:
    if isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            _check_size(each, name, field, counts=counts)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        least, most = LEAST.get(name, int(counts)), 1 if name in SHARES else MOST
        most = MOST_UNITS if name in UNITS else most
        if not least <= value <= most:
            raise InvalidInput(f"{field}: given {value}, allowed is {least} to {most:,}")
