"""The paper's reported numbers, and verdicts on their reproduction.

The numbers, their tolerances, their basis and the reasons are data (``numbers.yaml``); a verdict is
a plain comparison.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from importlib import resources
from typing import Literal, get_args

from pydantic import BaseModel, ConfigDict, model_validator

from hazbot_gym.errors import HazbotError
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.yaml_loader import parse_yaml

REPRODUCED, NEAR, NOT = "reproduced", "near", "not reproduced"
VERDICTS = (REPRODUCED, NEAR, NOT)
Basis = Literal["taken_over", "fitted", "predicted"]
BASES: tuple[Basis, ...] = get_args(Basis)
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
    relation: Literal["=", "<", ">"] = "="  # of the quantity to the number, as the paper states it
    unit: str
    rule: str
    basis: Basis | None = None  # of the value found here, None if there is none
    reason: str = ""  # reason for "near" or "not reproduced"


class Reported(BaseModel):
    """All reported numbers by id, and their tolerance rules."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    rules: dict[str, Rule]
    numbers: dict[str, Number]

    @model_validator(mode="after")
    def _is_consistent(self) -> Reported:
        for name, number in self.numbers.items():
            if number.rule not in self.rules:
                raise ValueError(f"{name}: unknown rule {number.rule!r}")
            if (number.rule == "absent") != (number.basis is None):
                raise ValueError(f"{name}: either a basis or the rule 'absent'")
            if number.rule == "stated" and number.basis != "taken_over":
                raise ValueError(f"{name}: a stated value is taken over")
            if number.rule != "absent" and (number.rule == "inequality") != (
                number.relation != "="
            ):
                raise ValueError(f"{name}: rule 'inequality' and relation contradict each other")
        return self


@cache
def reported() -> Reported:
    """Return the paper's reported numbers."""
    text = resources.files(__package__).joinpath("numbers.yaml").read_text(encoding="utf-8")
    return Reported.model_validate(parse_yaml(text, "numbers.yaml"))


def verdict(number: Number, here: float | None) -> str:
    """Return the verdict on a reproduced value, None if undefined."""
    if here is None:
        return f"{NOT}: {number.reason}"
    unmet = f"{NOT}: {number.reason or 'outside the tolerance for an unknown reason'}"
    if number.relation != "=":
        is_met = here < number.paper if number.relation == "<" else here > number.paper
        return REPRODUCED if is_met else unmet
    tolerance = reported().rules[number.rule].tolerance_for(number.paper)
    off = abs(here - number.paper) - ROUNDING * max(abs(here), abs(number.paper))
    if off <= tolerance:
        return REPRODUCED
    if off <= NEAR_TOLERANCES * tolerance:
        return NEAR
    return unmet


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
            "relation": number.relation,
            "here": here.get(name),
            "unit": number.unit,
            "tolerance": known.rules[number.rule].tolerance_for(number.paper),
            "rule": number.rule,
            "basis": number.basis,
            "verdict": verdict(number, here.get(name)),
            "reason": number.reason,
        }
        for name, number in known.numbers.items()
    ]


def count_verdicts(numbers: Iterable[JsonObject]) -> dict[str, int]:
    """Return the count of each verdict among entries."""
    words = [entry["verdict"].partition(":")[0] for entry in numbers]
    return {word: words.count(word) for word in VERDICTS}


def count_by_basis(numbers: list[JsonObject]) -> dict[str, dict[str, int]]:
    """Return the count of each verdict for each basis; numbers without a value here have none."""
    return {
        basis: count_verdicts(entry for entry in numbers if entry["basis"] == basis)
        for basis in BASES
    }
