from __future__ import annotations

import importlib

import pytest

from hazbot_gym.paper.lines import Line, lines

FIGURES = [*range(1, 6), "6a", "6b", "6c", "6d", *range(7, 20), "20a", "20b"]
ITEMS = {
    *(f"Equation {i}" for i in range(1, 16)),
    *(f"Table {i}" for i in range(1, 4)),
    *(f"Figure {i}" for i in FIGURES),
}


def test_every_equation_table_and_figure_of_the_paper_has_its_line() -> None:
    items = [line.item for line in lines()]
    assert len(items) == len(set(items))
    assert set(items) == ITEMS


@pytest.mark.parametrize("line", lines(), ids=lambda line: line.item.replace(" ", "-"))
def test_what_a_line_names_is_in_the_code(line: Line) -> None:
    for place in line.code:
        module, _, name = place.partition(":")
        assert hasattr(importlib.import_module(f"hazbot_gym.{module}"), name), place


def test_what_is_not_taken_as_printed_says_why() -> None:
    unexplained = [line.item for line in lines() if line.status == "corrected" and not line.note]
    assert unexplained == []
