"""Fitted response of people to the robot, as tables on the terminal."""

from __future__ import annotations

from rich.console import Group

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

CONSTANTS = ("constant", "fitted", "published")
LOSSES = ("loss", "fitted", "published")
GROUPS = (
    "scenario, robot", "encounters", "", "closest p10 [m]", "p50 [m]", "p90 [m]",
    "slowest, share of own pace",
)  # fmt: skip
VERDICTS = (
    "held out", "largest difference of closest distance [m]", "of slowest share",
    "within recorded 95 % intervals",
)  # fmt: skip
PRICES = ("price of nearness [s of delay per s of discomfort]", "estimate", "interval")
DRIVES = (
    "scenario, robot", "compliant: delay [s]", "discomfort [s]", "noncompliant: delay [s]",
    "discomfort [s]",
)  # fmt: skip
SIDES = {"recorded": "recorded", "model": "fitted model", "published": "published"}


def tables(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    blocks = [(CONSTANTS, constant_rows), (LOSSES, loss_rows), (GROUPS, group_rows)]
    blocks += [(VERDICTS, verdict_rows)]
    if record["price"] is not None:
        blocks += [(PRICES, price_rows), (DRIVES, drive_rows)]
    shown_tables = [console_table(titles, rows(record)) for titles, rows in blocks]
    counts = ", ".join(f"{count} encounters {side}" for side, count in record["encounters"].items())
    return Group(counts, "", *(part for each in shown_tables for part in (each, "")))


def constant_rows(record: Record) -> Rows:
    """Return name and values of each constant of the response."""
    published = record["published"]
    return [
        (f"`{name}`", shown(value), shown(published[name]))
        for name, value in record["response"].items()
    ]


def loss_rows(record: Record) -> Rows:
    """Return the loss on encounters fitted on and held out."""
    return [
        (f"encounters {side}", shown(loss["fitted"]), shown(loss["published"]))
        for side, loss in record["loss"].items()
    ]


def group_rows(record: Record) -> Rows:
    """Return recorded and model people of every group, one below the other."""
    return [
        (_name(row), str(row["encounters"]), name, *map(shown, row[side]))
        for row in record["groups"]
        for side, name in SIDES.items()
    ]


def verdict_rows(record: Record) -> Rows:
    """Return the largest differences of every group that was held out."""
    return [
        (
            _name(row),
            shown(row["largest_difference_m"]),
            shown(row["slowest_difference"]),
            f"{sum(inside := _inside(row))} of {len(inside)}",
        )
        for row in record["groups"]
        if not row["fitted_on"]
    ]


def price_rows(record: Record) -> Rows:
    """Return both estimates of the price with their intervals."""
    names = {
        "break_even": "compliant drives cost as much as noncompliant ones",
        "revealed": "speeds of compliant drives are nearest to optimal",
    }
    price = record["price"]
    return [
        (name, shown(price[key]["value"]), " to ".join(map(shown, price[key]["interval"])))
        for key, name in names.items()
    ]


def drive_rows(record: Record) -> Rows:
    """Return the mean delay and discomfort of both behaviours in every group."""
    return [
        (
            f"{row['scenario']}, {row['robot']}",
            *(
                shown(row[behaviour][field])
                for behaviour in ("compliant", "noncompliant")
                for field in ("delay_s", "felt_s")
            ),
        )
        for row in record["price"]["groups"]
    ]


def _inside(row: Record) -> list[bool]:
    """Return True for each statistic of the model in the interval of the recorded one."""
    pairs = zip(row["model"], row["recorded_intervals"], strict=True)
    return [low <= value <= high for value, (low, high) in pairs if None not in (value, low)]


def _name(row: Record) -> str:
    side = ", fitted on" if row["fitted_on"] else ""
    return f"{row['scenario']}, {row['robot']}{side}"
