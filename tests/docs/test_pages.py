"""The pages made of records are what their script makes of the committed records."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


def load_maker() -> Any:
    spec = importlib.util.spec_from_file_location("make", ROOT / "docs" / "make_pages.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MAKE = load_maker()
PAGES = tuple(MAKE.PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_page_is_what_the_script_makes_of_the_record(page: Any) -> None:
    assert (ROOT / "docs" / f"{page.name}.md").read_text(encoding="utf-8") == page.text()


def test_csv_tables_are_what_the_script_makes_of_the_records() -> None:
    made = MAKE.tables()
    assert {*made} == {*MAKE.TABLES.glob("*.csv")}
    for path, text in made.items():
        assert path.read_text(encoding="utf-8") == text


def test_the_readme_has_the_headline_of_the_study() -> None:
    assert (ROOT / "README.md").read_text(encoding="utf-8") == MAKE.readme()
