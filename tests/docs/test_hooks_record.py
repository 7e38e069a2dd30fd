"""Hooks that are not in use change neither numbers nor speed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import make_hooks_record
import pytest
from make_hooks_record import UNUSED, CorridorStepper, Stepper, record

from hazbot_gym.core.own_terms import REWARD_TERMS
from hazbot_gym.core.own_walking import PEDESTRIAN_MODELS
from hazbot_gym.utils.files import read_json
from hazbot_gym.utils.json_object import JsonObject

COMMITTED: JsonObject = read_json(Path(__file__).parents[2] / "benchmarks" / "hooks.json")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Measure for a moment, and forget the hooks."""
    limits = {"TURNS": 2, "WORLDS": 4, "SPREAD": 3, "DECISIONS": 60}
    for name, value in limits.items():
        monkeypatch.setattr(make_hooks_record, name, value)
    monkeypatch.setattr(make_hooks_record, "CALLS", {Stepper: 3, CorridorStepper: 3})
    yield
    REWARD_TERMS.clear()
    PEDESTRIAN_MODELS.clear()


@pytest.mark.usefixtures("short")
def test_the_same_bits_with_and_without_hooks() -> None:
    found = record()
    assert [row["is_equal"] for row in found["rows"]] == 6 * [True]
    cases = [[(row["engine"], row["hooks"]) for row in each["rows"]] for each in (found, COMMITTED)]
    assert cases[0] == cases[1]
    assert found.keys() == COMMITTED.keys() - {"checksum"}


def test_the_record_says_that_nothing_changes_where_no_hook_is_used() -> None:
    assert all(row["is_equal"] for row in COMMITTED["rows"])
    unused = [row["to_no_hooks"] for row in COMMITTED["rows"] if row["hooks"] == UNUSED]
    assert unused == pytest.approx([1.0, 1.0], abs=0.03)
