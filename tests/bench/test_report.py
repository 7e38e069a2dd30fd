from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console

from hazbot_gym.bench.report import shown, table


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1234567.8, "1,230,000"),
        (999.6, "1,000"),
        (123.4, "123"),
        (9.876, "9.88"),
        (0.01234, "0.0123"),
    ],
)
def test_numbers_have_three_digits_that_count(value: float, text: str) -> None:
    assert shown(value) == text


def test_terminal_shows_cases_goals_and_machine(record: dict[str, Any]) -> None:
    out = io.StringIO()
    Console(file=out, width=120).print(table(record))
    for text in (
        "hazbot_gym/Corridor-v1",
        "batched, 8192 worlds, 10 people",
        "at least 60",
        "four people",
        "1.25 s (1.25 to 1.25) cached, 1.25 s compiling",
        "fuzzy-PID",
        "SB3 adapter left out",
        record["machine"]["processor"],
    ):
        assert text in out.getvalue()
