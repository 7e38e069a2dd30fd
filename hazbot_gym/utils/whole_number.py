"""Validation of whole numbers, Python's or NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np

from hazbot_gym.errors import InvalidInput


def whole_number(given: Any, name: str, low: int, high: int | None = None) -> int:
    """Return a whole number that is at least ``low`` and at most ``high``; booleans are rejected.

    Raises:
        InvalidInput: Any other value; one line with its name and the allowed range.
    """
    is_whole = isinstance(given, int | np.integer) and not isinstance(given, bool)
    if not is_whole or given < low or (high is not None and given > high):
        allowed = f"of at least {low}" if high is None else f"from {low} to {high:,}"
        raise InvalidInput(f"{name}: given {given!r:.80}, allowed are integers {allowed}")
    return int(given)
