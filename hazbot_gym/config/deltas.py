"""Deltas on a config: nested mappings, one laid over another."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hazbot_gym.config.section import Section, name_of, shown
from hazbot_gym.core.pid import PLANTS
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.json_object import JsonObject


def merge(base: Mapping[str, object], deltas: Mapping[str, object]) -> JsonObject:
    """Return ``base`` with ``deltas`` laid over it, section by section.

    Raises:
        InvalidInput: Deltas change a part of a value that ``base`` gives by name, or as a list.
    """
    merged = dict(base)
    for key, value in deltas.items():
        below = merged.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            value = merge(below, value)
        elif isinstance(value, Mapping) and len(value) < _parts(below):
            raise InvalidInput(
                f"{name_of(key)}: given a part, {shown(dict(value))}, of {shown(below)}; allowed "
                f"are all {_parts(below)} values"
            )
        merged[key] = value
    return merged


def _parts(below: object) -> int:
    """Return the number of values of a mapping that replaces a name or list."""
    if isinstance(below, str):
        return len(PLANTS.get(below, ()))
    return len(below) if isinstance(below, list | tuple) else 0


def plain(value: Any) -> Any:
    """Return deltas with NumPy values converted to Python's."""
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if type(value) in (list, tuple):
        return [plain(each) for each in value]
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def as_mappings(value: object) -> Any:
    """Return a section and its named tuples as mappings, for merging."""
    if isinstance(value, Section):
        return {name: as_mappings(getattr(value, name)) for name in type(value).model_fields}
    return value._asdict() if hasattr(value, "_asdict") else value
