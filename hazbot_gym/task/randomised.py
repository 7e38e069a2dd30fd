"""Configs of single episodes: randomised values as a pure function of the scenario's key."""

from __future__ import annotations

import zlib
from typing import Any, NamedTuple

import numpy as np

from hazbot_gym.config import Config, with_value
from hazbot_gym.config.randomised import extreme_values, value_at, value_from
from hazbot_gym.core.noise import CONFIG, normal_pair, uniform4
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.scenario import ScenarioSampler


class Drawn(NamedTuple):
    """Config of an episode, and its randomised values by dotted name."""

    config: Config
    values: dict[str, Any]


def draw_config(config: Config, key: int) -> Drawn:
    """Return the config of the scenario of a key.

    A value depends on the key and the name of its field alone, not on what else is randomised.

    Raises:
        InvalidInput: The values do not fit each other.
    """
    if not config.randomised:
        return Drawn(config, {})
    values = {name: _draw(config, name, key) for name in config.randomised}
    try:
        return Drawn(with_value(config, values), values)
    except InvalidInput as error:
        raise InvalidInput(f"{error} (randomised, scenario {key})") from error


def _draw(config: Config, name: str, key: int) -> Any:
    u, u_1, u_2, _ = uniform4(np.uint64(key), CONFIG, zlib.crc32(name.encode()), 0)
    normal, _ = normal_pair(u_1, u_2)
    is_whole = isinstance(value_at(config, name), int)
    return value_from(config.randomised[name], float(u), normal, is_whole=is_whole)


def most_people(config: Config, usual: int) -> int:
    """Return the largest number of PERSON records of a scenario, and try all extreme values.

    Args:
        config: The config.
        usual: The number with nothing drawn.

    Raises:
        InvalidInput: A place or a crowd is impossible with one of them.
    """
    extremes = [with_value(config, {name: value}) for name, value in extreme_values(config)]
    return max([usual, *(ScenarioSampler(each).people for each in extremes)])
