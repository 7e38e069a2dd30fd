"""Index of the paper's equations, tables and figures, with their locations in the code."""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Literal

from pydantic import BaseModel, ConfigDict, TypeAdapter

from hazbot_gym.utils.yaml_loader import parse_yaml


class Line(BaseModel):
    """An equation, a table or a figure; see ``lines.yaml``."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    item: str
    what: str
    status: Literal["taken", "corrected", "chosen", "absent"]
    code: list[str]
    note: str = ""


@cache
def lines() -> list[Line]:
    """Return all of them, in the paper's order."""
    text = resources.files(__package__).joinpath("lines.yaml").read_text(encoding="utf-8")
    return TypeAdapter(list[Line]).validate_python(parse_yaml(text, "lines.yaml"))
