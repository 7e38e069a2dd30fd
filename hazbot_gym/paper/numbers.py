"""The paper's reported numbers, and verdicts on their reproduction.

The numbers, their tolerances and the reasons are data (``numbers.yaml``), written before any run; a
verdict is a plain comparison.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources

from pydantic import BaseModel, ConfigDict, model_validator

from hazbot_gym.errors import HazbotError
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import parse_yaml

REPRODUCED, NEAR, NOT = "reproduced", "near", "not reproducible"
NEAR_TOLERANCES = 2.0  # a value within this many tolerances is "near"
ROUNDING = 1e-9  # relative slack of the comparison, for rounding of 4.6 - 4.4


class Rule(BaseModel):
    """Tolerance rule: absolute, or relative to the paper's value."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    tolerance: float | None = None
    relative: float | None = None
    why: str

    @model_validator(mode="after")
    def _is_one_of_both(self) -> Rule:
        if (self.tolerance is None) == (self.relative is None):
            raise ValueError("a rule has either a tolerance or a relative one")
        return self

    def tolerance_for(self, paper: float) -> float:
        """Return the tolerance for a number of the paper, in its unit."""
        return abs(paper) * self.relative if self.relative is not None else self.tolerance or 0.0


class Number(BaseModel):
    """A number that the paper reports."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    where: str  # section, table or figure
    what: str
    paper: float
    unit: str
    rule: str
    reason: str = ""  # reason for "near" or "not reproducible"


class Reported(BaseModel):
    """All reported numbers by id, and their tolerance rules."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    rules: dict[str, Rule]
    numbers: dict[str, Number]


@cache
def reported() -> Reported:
    """Return the paper's reported numbers."""
    text = resources.files(__package__).joinpath("numbers.yaml").read_text(encoding="utf-8")
    return Reported.model_validate(parse_yaml(text, "numbers.yaml"))


def verdict(number: Number, here: float | None) -> str:
    """Return the verdict on a reproduced value, None if undefined."""
    if here is None:
        return f"{NOT}: {number.reason}"
    tolerance = reported().rules[number.rule].tolerance_for(number.paper)
    off = abs(here - number.paper) - ROUNDING * max(abs(here), abs(number.paper))
    if off <= tolerance:
        return REPRODUCED
    if off <= NEAR_TOLERANCES * tolerance:
        return NEAR
    return f"{NOT}: {number.reason or 'outside the tolerance for an unknown reason'}"


def entries(here: Mapping[str, float]) -> list[JsonObject]:
    """Return one entry for each reported number, in the paper's order.

    Args:
        here: Reproduced values, by id.

    Raises:
        HazbotError: Reproduced and reported numbers do not match one to one.
    """
    known = reported()
    expected = {name for name, number in known.numbers.items() if number.rule != "absent"}
    if expected != set(here):
        missing, unknown = sorted(expected - set(here)), sorted(set(here) - expected)
        raise HazbotError(f"paper: no value for {missing}, and nothing reported for {unknown}")
    return [
        {
            "id": name,
            "source": number.where,
            "what": number.what,
            "paper": number.paper,
            "here": here.get(name),
            "unit": number.unit,
            "tolerance": known.rules[number.rule].tolerance_for(number.paper),
            "rule": number.rule,
            "verdict": verdict(number, here.get(name)),
            "reason": number.reason,
        }
        for name, number in known.numbers.items()
    ]
