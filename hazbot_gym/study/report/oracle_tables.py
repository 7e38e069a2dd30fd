"""Report tables: Pareto fronts, prices, regret, tails, and out-of-distribution sets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hazbot_gym.evaluation.prices import RETURNS
from hazbot_gym.study.report.tables import Cell, Line, Table
from hazbot_gym.study.results import Family, Interval, OracleComparison, SetResults

# Of ``summary["oracle"]``: field, title, scale, digits.
REGRETS = (
    ("regret", "regret, in return", 1.0, 2),
    ("normalised", "normalised, constant speed to oracle, %", 100.0, 1),
    ("avoidable_delay_s", "avoidable delay, s", 1.0, 2),
)
# Of ``tails`` of a policy: metric, title.
TAILS = (
    ("clearance_min_m", "minimum clearance, m"),
    ("ttc_min_s", "minimum time to collision, s"),
    ("discomfort_s", "discomfort, s"),
    ("delay_s", "delay, s"),
)
# Shown for out-of-distribution places, people and robots: metric, title, scale, digits.
ELSEWHERE = (
    ("delay_s", "delay, s", 1.0, 2),
    ("personal_m", "in the personal zone, m", 1.0, 2),
    ("discomfort_s", "discomfort, s", 1.0, 2),
    ("contacts_per_km", "contacts by robot per km", 1.0, 2),
)


def regret_table(block: OracleComparison, names: Sequence[str]) -> Table:
    """Return the regret of each policy relative to the oracle, one row per policy."""
    head = [title for _, title, _, _ in REGRETS]
    lines = [
        Line(
            name,
            [
                _cell(block["policies"][name].get(field), scale, digits)
                for field, _, scale, digits in REGRETS
            ],
        )
        for name in names
    ]
    return Table(head, lines)


def family_table(block: dict[str, Family]) -> Table:
    """Return each family's hypervolume and its differences from the first and the largest."""
    head = [
        "hypervolume",
        "difference from the first",
        "difference from the largest",
        "points",
        "points on the front",
    ]
    lines = [
        Line(
            name,
            [
                _cell(found["hypervolume"], 1.0, 4),
                _cell(found["difference"], 1.0, 4),
                _behind(found["behind"]),
                Cell(str(len(found["points"])), ""),
                Cell(str(sum(point["on_front"] for point in found["points"])), ""),
            ],
        )
        for name, found in block.items()
    ]
    return Table(head, lines)


def _behind(difference: Interval) -> Cell:
    """Return the difference from the largest hypervolume, with the verdict of its interval."""
    cell, high = _cell(difference, 1.0, 4), difference["high"]
    if difference["mean"] == 0.0:
        return Cell("largest", "")
    is_tie = high is not None and high >= 0.0
    return cell._replace(interval=f"{cell.interval}; tie") if is_tie else cell


def price_table(block: SetResults, names: Iterable[str]) -> Table:
    """Return the return of each policy at several prices of nearness, one row per policy."""
    return Table(
        [f"at {price:g} s" for price in RETURNS.values()],
        [
            Line(name, [_cell(block[name]["metrics"][metric], 1.0, 1) for metric in RETURNS])
            for name in names
        ],
    )


def tail_table(block: SetResults, names: Iterable[str]) -> Table:
    """Return the mean of the worst 5 % of each policy's episodes, one row per policy."""
    return Table(
        [title for _, title in TAILS],
        [
            Line(name, [_cell(block[name]["tails"].get(metric), 1.0, 2) for metric, _ in TAILS])
            for name in names
        ],
    )


def elsewhere_tables(blocks: dict[str, SetResults], names: Sequence[str]) -> dict[str, Table]:
    """Return one table per metric: one row per group of sets, one column per policy."""
    return {
        title: Table(
            list(names),
            [
                Line(
                    group,
                    [_cell(block[name]["metrics"].get(metric), scale, digits) for name in names],
                )
                for group, block in blocks.items()
            ],
        )
        for metric, title, scale, digits in ELSEWHERE
    }


def _cell(estimate: Interval | None, scale: float, digits: int) -> Cell:
    if estimate is None or estimate["mean"] is None:
        return Cell("?", "")
    mean, low, high = (
        "?" if (value := estimate[end]) is None else f"{scale * value:z.{digits}f}"
        for end in ("mean", "low", "high")
    )
    return Cell(mean, "" if "?" in (low, high) else f"{low} to {high}")
