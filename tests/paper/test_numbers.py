from __future__ import annotations

import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from hazbot_gym.errors import HazbotError
from hazbot_gym.paper.numbers import (
    Number,
    Reported,
    Rule,
    count_by_basis,
    entries,
    reported,
    verdict,
)

PAPER = sorted((Path(__file__).parents[3] / "shared" / "paper").glob("*.txt"))
VALUE = re.compile(r"(?<![\w.])-? ?\d+(?:\.\d+)?(?![\w])")
# What is no reported number: those of equations, figures, tables, their rows, sections, references,
# and of formulas, whose coefficients are in the code.
NO_NUMBERS = re.compile(
    r"\$[^$]*\$|\[[\d, -]+\]|\((?:\d+|\d+[a-c])\)|"
    r"(?:Figures?|Tables?|Eqs?\.) ?\(?\d+|^#* ?\d(?:\.\d)* [A-Z][^.\n]*$|"
    r"^\d(?=\t)|STM32F103|H\.264|Simulation experiment \d|1966|Frame",
    re.DOTALL | re.MULTILINE,
)


def clean(text: str) -> str:
    """Return text without its numbered equations, and with plain dashes."""
    return re.sub(r"\$\$.*?\$\$", " ", text, flags=re.DOTALL).replace("\u2013", "-")


def numbers_of(text: str) -> set[float]:
    """Return the numbers of running text, in figures."""
    plain = NO_NUMBERS.sub(" ", clean(text))
    return {abs(float(found.replace(" ", ""))) for found in VALUE.findall(plain)}


def formulas_of(text: str) -> set[float]:
    """Return the numbers of inline formulas that give a symbol its value, such as $a_1 = -1$."""
    formulas = re.findall(r"\$([^$]+)\$", clean(text))
    values = (re.findall(r"(?:=|pm) *(-?\d+(?:\.\d+)?) *$", formula) for formula in formulas)
    return {abs(float(value)) for found in values for value in found}


def test_no_number_of_the_paper_is_missing() -> None:
    if not PAPER:
        pytest.skip("the paper's text is not here")
    text = PAPER[0].read_text(encoding="utf-8")
    start, end = text.index("2 Overall Design"), text.index("Acknowledgements")
    known = {abs(number.paper) for number in reported().numbers.values()}
    found = numbers_of(text[start:end]) | formulas_of(text[start:end])
    assert len(found) > 50
    assert sorted(found - known) == []


def test_a_missing_number_would_be_found() -> None:
    text = "At $t$ = 4.6 s (Figure 13) it stops, see [31] and Eq. (9); set as $a_1 = -1.2$ here."
    assert numbers_of(text) == {4.6}
    assert formulas_of(text) == {1.2}


def number(rule: str, paper: float, reason: str = "") -> Number:
    return Number(where="", what="", paper=paper, unit="s", rule=rule, reason=reason)


def bound(relation: str, paper: float) -> Number:
    return Number.model_validate(
        number("inequality", paper).model_dump() | {"relation": relation, "basis": "predicted"}
    )


@pytest.mark.parametrize(
    ("here", "expected"),
    [
        (3.4, "reproduced"),
        (3.6, "reproduced"),
        (3.2, "reproduced"),
        (3.61, "near"),
        (3.8, "near"),
        (3.81, "not reproduced: too slow"),
        (None, "not reproduced: too slow"),
    ],
)
def test_a_verdict_is_a_comparison_with_the_tolerance(here: float | None, expected: str) -> None:
    assert verdict(number("simulated_time", 3.4, "too slow"), here) == expected


def test_what_is_stated_must_be_equal_and_a_relative_tolerance_grows_with_the_number() -> None:
    assert verdict(number("stated", 0.2), 0.2) == "reproduced"
    assert verdict(number("stated", 0.2), 0.2001).startswith("not reproduced")
    assert Rule(relative=0.1, why="").tolerance_for(-20.0) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("relation", "here", "expected"),
    [
        ("<", 0.0979, "reproduced"),
        ("<", 0.098, "not reproduced"),
        ("<", 0.0981, "not reproduced"),  # however near
        (">", 0.0981, "reproduced"),
        (">", 0.098, "not reproduced"),
    ],
)
def test_a_bound_is_met_or_not(relation: str, here: float, expected: str) -> None:
    assert verdict(bound(relation, 0.098), here).partition(":")[0] == expected


def test_every_number_that_is_absent_or_a_bound_has_a_reason() -> None:
    for name, each in reported().numbers.items():
        assert each.reason or each.rule not in {"absent", "inequality"}, name


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"rule": "guess"}, "unknown rule"),
        ({"basis": None}, "either a basis or"),
        ({"rule": "absent"}, "either a basis or"),
        ({"rule": "stated"}, "taken over"),
        ({"relation": "<"}, "contradict"),
        ({"rule": "inequality"}, "contradict"),
        ({"basis": "guessed"}, "taken_over"),
    ],
)
def test_contradictory_numbers_are_refused(change: dict[str, str], complaint: str) -> None:
    rules = {name: rule.model_dump() for name, rule in reported().rules.items()}
    good = number("motor", 1.0).model_dump() | {"basis": "fitted"}
    Reported.model_validate({"rules": rules, "numbers": {"x": good}})
    with pytest.raises(ValidationError, match=complaint):
        Reported.model_validate({"rules": rules, "numbers": {"x": good | change}})


def test_verdicts_are_counted_by_basis() -> None:
    found = [
        {"basis": "fitted", "verdict": "reproduced"},
        {"basis": "predicted", "verdict": "not reproduced: too slow"},
        {"basis": "predicted", "verdict": "near"},
        {"basis": None, "verdict": "not reproduced: absent"},
    ]
    assert count_by_basis(found) == {
        "taken_over": {"reproduced": 0, "near": 0, "not reproduced": 0},
        "fitted": {"reproduced": 1, "near": 0, "not reproduced": 0},
        "predicted": {"reproduced": 0, "near": 1, "not reproduced": 1},
    }


def test_entries_are_complete_and_no_others() -> None:
    known = reported().numbers
    here = {name: each.paper for name, each in known.items() if each.rule != "absent"}
    found = entries(here)
    assert [entry["id"] for entry in found] == list(known)
    assert {entry["verdict"].partition(":")[0] for entry in found} == {
        "reproduced",
        "not reproduced",
    }
    with pytest.raises(HazbotError, match="k_e"):
        entries({name: value for name, value in here.items() if name != "k_e"})
    with pytest.raises(HazbotError, match="'x'"):
        entries({**here, "x": 1.0})
