"""Configuration: every parameter of the problem, validated, with its unit; named scenarios.

Parameters of an equation live beside that equation in ``core`` and are composed here. A config is
given as a ``Config``, as a mapping of deltas on the defaults, or as a YAML file of such deltas.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hazbot_gym.config.deltas import as_mappings, merge, plain
from hazbot_gym.config.parameters import (
    Clock,
    Config,
    Drive,
    Gas,
    People,
    RewardWeights,
    Sensors,
    Speeds,
    Tracker,
    Walker,
)
from hazbot_gym.config.randomised import (
    RANDOMISED,
    extreme_values,
    has_parts,
    is_set,
    replaced,
    taken_out,
)
from hazbot_gym.config.scenarios import SCENARIOS
from hazbot_gym.config.section import first_error, name_of, shown
from hazbot_gym.errors import InvalidInput, UnknownKeyword
from hazbot_gym.utils.yaml_loader import read_yaml

__all__ = [
    "SCENARIOS", "Clock", "Config", "Drive", "Gas", "People", "RewardWeights", "Sensors", "Speeds",
    "Tracker", "Walker", "horizon_in", "make_config", "with_value",
]  # fmt: skip


def make_config(
    given: Config | Mapping[str, object] | str | Path | None = None,
    /,
    *,
    preset: Mapping[str, object] | None = None,
    scenario: str | None = None,
    **overrides: object,
) -> Config:
    """Return a validated config: defaults, then preset, named scenario, ``given``, and overrides.

    Args:
        given: A config, a mapping of deltas, or the path of a YAML file of deltas.
        preset: Deltas of a registered environment.
        scenario: A name of ``SCENARIOS``.
        **overrides: Fields of ``Config``; sections as mappings of deltas. A distribution may stand
            in place of a value (``config/randomised.py``).

    Raises:
        InvalidInput: One line that names the field, what was given and what is allowed.
        UnknownKeyword: The same, where an override is no field.
    """
    if not isinstance(preset, Mapping | None):
        raise InvalidInput(f"preset: given {preset!r}, allowed is a mapping")
    if scenario is not None and not (isinstance(scenario, str) and scenario in SCENARIOS):
        raise InvalidInput(f"scenario: given {scenario!r}, allowed are {', '.join(SCENARIOS)}")
    for name in overrides.keys() - Config.model_fields.keys():
        raise UnknownKeyword(
            f"{name_of(name)}: unknown key, allowed are {', '.join(Config.model_fields)} "
            f"(unexpected keyword argument {name!r})"
        )
    deltas, randomised = dict[str, object](), dict[str, Any]()
    for layer in (preset or {}, SCENARIOS[scenario] if scenario else {}, _deltas(given), overrides):
        values, own = taken_out(plain(layer))
        left = {name: each for name, each in randomised.items() if not is_set(values, name)}
        deltas, randomised = merge(deltas, values), left | own
    try:
        config = _validated({**deltas, RANDOMISED: randomised})
    except InvalidInput as error:
        name = str(error).partition(": ")[0]
        if name not in randomised:
            raise
        said = f"{name}: given {shown(randomised[name])}"
        if has_parts(Config(), name):
            allowed = "a distribution in place of single numbers or names in it"
            raise InvalidInput(f"{said}, allowed is {allowed}") from error
        raise InvalidInput(f"{said}: {error}") from error
    for name, value in extreme_values(config):
        try:
            with_value(config, {name: value})
        except InvalidInput as error:
            said = f"{shown(randomised[name])}, which includes {value!r}"
            raise InvalidInput(f"{name}: given {said}: {error}") from error
    return config


def with_value(config: Config, values: Mapping[str, object]) -> Config:
    """Return a config with other values of some fields, by dotted name, and nothing randomised.

    Raises:
        InvalidInput: One line that names the field, what was given and what is allowed.
    """
    whole = {**as_mappings(config), RANDOMISED: {}}
    for name, value in values.items():
        whole = replaced(whole, name, value)
    return _validated(plain(whole))


def _validated(values: Mapping[str, object]) -> Config:
    try:
        return Config.model_validate(values)
    except ValidationError as error:
        raise InvalidInput(first_error(error, Config)) from error


def horizon_in(
    given: Config | Mapping[str, object] | str | Path | None, scenario: object
) -> object:
    """Return the ``max_episode_steps`` of a config, else of a named scenario; or None."""
    named = SCENARIOS.get(scenario, {}) if isinstance(scenario, str) else {}
    return {**named, **_deltas(given)}.get("max_episode_steps")


def _deltas(given: Config | Mapping[str, object] | str | Path | None) -> Mapping[str, object]:
    """Return the argument of ``make_config`` as a mapping."""
    if isinstance(given, Config):
        return dict(as_mappings(given))
    if isinstance(given, str | Path):
        return read_yaml(Path(given))
    if given is not None and not isinstance(given, Mapping):
        kind = type(given).__name__
        raise InvalidInput(f"config: given {kind}, allowed are a Config, a mapping or a path")
    return given or {}
