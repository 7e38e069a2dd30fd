"""The type of an object of JSON or YAML as it is read: names and values of several kinds."""

from __future__ import annotations

from typing import Any

JsonObject = dict[str, Any]  # where a value is only passed on: Mapping[str, object]
