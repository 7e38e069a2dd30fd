from __future__ import annotations

from typing import Any

from hazbot_gym.study.report import oracle_tables, tables
from hazbot_gym.study.summary import COMPARED
from hazbot_gym.study.terminal_tables import COLUMNS


def estimate(mean: float | None) -> dict[str, float | None]:
    low, high = (None, None) if mean is None else (mean - 0.25, mean + 0.25)
    return {"mean": mean, "low": low, "high": high}


def result(value: float | None) -> dict[str, Any]:
    names = [*(column.metric for column in COLUMNS), "stl"]
    return {
        "metrics": {name: estimate(value) for name in names},
        "difference": {name: estimate(value) | {"p_holm": 0.0123} for name in COMPARED},
    }


def test_the_headline_shows_percent_and_interval_and_marks_the_best() -> None:
    table = tables.headline({"a": result(0.5), "b": result(0.25)}, ("a", "b"))
    assert table.head[6] == "arrived %"
    a, b = table.lines
    assert a.cells[6] == ("50.0", "25.0 to 75.0", True)  # more arrive
    assert b.cells[6] == ("25.0", "0.0 to 50.0", False)
    assert [cell.is_best for cell in b.cells[:6]] == [True] * 6  # less of all the rest
    assert a.cells[-1].is_best  # a larger return


def test_means_that_round_to_the_same_are_both_best() -> None:
    table = tables.headline({"a": result(0.50004), "b": result(0.5)}, ("a", "b"))
    assert all(line.cells[0].is_best for line in table.lines)


def test_what_is_not_known_is_shown_as_such_and_is_never_best() -> None:
    table = tables.headline({"a": result(None), "b": result(1.0)}, ("a", "b"))
    assert table.lines[0].cells[0] == ("?", "", False)
    assert table.lines[1].cells[0].is_best


def test_all_metrics_are_listed_the_known_ones_first() -> None:
    table = tables.all_metrics({"a": result(0.123456)}, ("a",))
    assert table.head == ["a"]
    assert len(table.lines) == len(COLUMNS) + 1
    assert (table.lines[-1].name, table.lines[-1].cells[0].mean) == ("stl", "0.123")


def test_differences_leave_out_the_reference() -> None:
    block = {"a": result(0.0), "b": result(-1.0)}
    table = tables.differences(block, ("a", "b"), "a")
    assert [line.name for line in table.lines] == ["b"]
    assert table.lines[0].cells[2][:2] == ("-1.000", "-1.250 to -0.750; p = 0.012")
    assert tables.p_text(1e-12) == "< 0.001"


def test_families_whose_areas_differ_by_less_than_their_interval_tie() -> None:
    areas = {"largest": (0.0, 0.0, 0.0), "near": (-0.1, -0.3, 0.1), "far": (-0.5, -0.6, -0.4)}
    block: Any = {
        name: {
            "hypervolume": estimate(1.0),
            "difference": estimate(0.5),
            "behind": dict(zip(("mean", "low", "high"), behind, strict=True)),
            "points": [],
        }
        for name, behind in areas.items()
    }
    cells = [line.cells[2] for line in oracle_tables.family_table(block).lines]
    assert [cell.mean for cell in cells] == ["largest", "-0.1000", "-0.5000"]
    assert ["tie" in cell.interval for cell in cells] == [False, True, False]


def test_dominating_policies_are_named_the_first_of_many() -> None:
    by: dict[str, list[str] | None] = {
        "best": [],
        "p3": ["best", "p1", "p2"],
        "p5": ["best", "p1", "p2", "p3", "p4"],
        "unknown": None,
    }
    found = tables.dominated({policy: {"dominated_by": some} for policy, some in by.items()})
    assert found == {"p3": "best, p1, p2", "p5": "best, p1, p2 and 2 more"}
