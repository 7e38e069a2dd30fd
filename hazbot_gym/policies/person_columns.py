"""Columns of an observation for compiled rules, with factors to physical units."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats, Ints
from hazbot_gym.task.observation import Layout


class Columns(NamedTuple):
    """Columns of an observation, ready for kernels."""

    entries: Ints  # (K, fields) of each person's
    units: Floats  # (K, fields) factors to physical units
    own: Ints  # (2,) of the robot's speed and its last command
    own_units: Floats  # (2,)


@cache
def columns_of(layout: Layout, fields: tuple[str, ...]) -> Columns:
    """Return the columns of some fields of every person in observations of a layout."""
    slots = range(layout.person_slots)
    index = [[layout.names.index(f"person{i}_{name}") for name in fields] for i in slots]
    units = [[layout.fields[column].scale for column in row] for row in index]
    own = [layout.names.index(name) for name in ("speed_mps", "command_mps")]
    own_units = [layout.fields[column].scale for column in own]
    return Columns(np.array(index), np.array(units), np.array(own), np.array(own_units))
