"""Fitted discomfort of nearness, as tables on the terminal."""

from __future__ import annotations

from rich.console import Group

from hazbot_gym.calibration.discomfort import DIRECTIONS
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

CURVE = ("constant", "fitted", "interval")
BOUNDS = ("clearance [m]", *DIRECTIONS)
BINS = ("distance [m]", "ratings", *DIRECTIONS)
ERRORS = ("model of the ratings", "RMS error on other raters")


def tables(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    blocks = ((CURVE, curve_rows), (BOUNDS, bound_rows), (BINS, bin_rows), (ERRORS, error_rows))
    shown_tables = [console_table(titles, rows(record)) for titles, rows in blocks]
    counts = f"{record['ratings']} ratings by {record['raters']} people"
    return Group(counts, "", *(part for each in shown_tables for part in (each, "")))


def curve_rows(record: Record) -> Rows:
    """Return the constants of the curve with their intervals."""
    return [
        (name, shown(record["curve"][name]), _interval(interval))
        for name, interval in record["intervals"].items()
    ]


def bound_rows(record: Record) -> Rows:
    """Return the discomfort at the bounds of Hall's phases, by direction."""
    return [
        (
            shown(row["clearance_m"]),
            *(
                "{:.2f} ({:.2f} to {:.2f})".format(row[name]["value"], *row[name]["interval"])
                for name in DIRECTIONS
            ),
        )
        for row in record["bounds"]
    ]


def bin_rows(record: Record) -> Rows:
    """Return the mean rated discomfort by distance and direction."""
    return [
        (
            "no people" if row["low_m"] is None else f"{row['low_m']:g} to {row['high_m']:g}",
            str(row["ratings"]),
            *(shown(row[name]) for name in DIRECTIONS),
        )
        for row in record["bins"]
    ]


def error_rows(record: Record) -> Rows:
    """Return the error of each model on raters it was not fitted on."""
    return [(name, f"{error:.4f}") for name, error in record["error_on_other_raters"].items()]


def _interval(bounds: list[float]) -> str:
    return " to ".join(shown(each) for each in bounds)
