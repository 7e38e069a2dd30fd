"""The pages made of records say what the committed records say, number by number."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hazbot_gym.evaluation.oracle.headroom_report import percent
from hazbot_gym.paper.tables import shown as as_printed
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.text_tables import shown

ROOT = Path(__file__).parents[1]
NUMBER = re.compile(r"\d[\d,]*(?:\.\d+)*")
NAMES = re.compile(r"`[^`]*`|\b(?:uo|boa|bot)-[\w-]+|p\d+")  # of runs and percentiles, no figures


def load_maker() -> Any:
    spec = importlib.util.spec_from_file_location("make", ROOT / "docs" / "make_pages.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MAKE = load_maker()
PAGES = tuple(MAKE.PAGES)
KNOWN = {"1995", "2022", "95"}  # years of references, percents: of arrivals aimed for, of intervals


def leaves(value: Any) -> Iterator[Any]:
    """Yield every name and value of a record."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield name
            yield from leaves(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from leaves(inner)
    else:
        yield value


def numbers(text: str) -> set[str]:
    return {number.rstrip(",") for number in NUMBER.findall(NAMES.sub("", text))}


def numbers_of(record: Any, *, in_percent: bool = False, fixed: bool = False) -> set[str]:
    """Return all numbers of a record as pages write them; if asked in percent or fixed digits."""
    found: set[str] = set()
    for leaf in leaves(record):
        found |= numbers(str(leaf) if isinstance(leaf, str | int) else shown(leaf))
        if isinstance(leaf, int | float):
            found |= numbers(as_printed(leaf))
        if fixed and isinstance(leaf, float):
            found |= {each for digits in range(5) for each in numbers(f"{leaf:z.{digits}f}")}
        if in_percent and isinstance(leaf, float):
            found |= numbers(percent(leaf))
    return found


def test_a_number_that_is_not_in_the_record_is_found() -> None:
    record = {"12 worlds": {"rate": 4567.8, "turns": 3}, "python": "3.11.7"}
    assert numbers("4,570 in 12 worlds, 3 turns, 3.11.7") <= numbers_of(record)
    assert numbers("4,580 in 13 worlds") & numbers_of(record) == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_page_is_what_the_script_makes_of_the_record(page: Any) -> None:
    assert (ROOT / "docs" / f"{page.name}.md").read_text(encoding="utf-8") == page.text()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_number_of_the_page_is_in_the_record(page: Any) -> None:
    record = [read_json(each) for each in (page.record, *page.others.values())]
    text = (ROOT / "docs" / f"{page.name}.md").read_text(encoding="utf-8")
    known = (
        numbers_of(record, in_percent=page.name == "headroom", fixed=page.name == "study") | KNOWN
    )
    assert numbers(text) - known == set()


def test_the_readme_has_the_headline_of_the_study() -> None:
    assert (ROOT / "README.md").read_text(encoding="utf-8") == MAKE.readme()
