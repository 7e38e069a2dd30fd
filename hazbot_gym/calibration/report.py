"""Calibration results, as tables on the terminal."""

from __future__ import annotations

from rich.console import Group

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

CONSTANTS = ("constant", "fitted", "as shipped", "Helbing and Molnár 1995")
LOSSES = ("loss on the runs fitted on", "fitted", "as shipped", "Helbing and Molnár 1995")
SPEEDS = ("run", "people per m²", "moments", "real", "model", "drawn", "Helbing and Molnár 1995")
DIFFERENCES = ("mean speed off at worst [m/s]", "as calibrated", "Helbing and Molnár 1995")
DISTANCES = ("run", "", "came in", "nearest", "nearest p5", "encountering", "confronting")
PERCENTILES = ("run", "", "p5", "p25", "p50", "p75", "p95")
SETS = ("fitted", "shipped", "helbing_molnar_1995")
SIDES = ("real", "model", "drawn speeds", "helbing_molnar_1995")


def tables(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    blocks = ((CONSTANTS, constant_rows), (LOSSES, loss_rows), (SPEEDS, speed_rows))
    more = ((DISTANCES, distance_rows), (PERCENTILES, percentile_rows))
    shown_tables = [console_table(titles, rows(record)) for titles, rows in (*blocks, *more)]
    return Group(*(part for each in shown_tables for part in (each, "")), _verdict(record))


def is_near(run: Record, record: Record) -> bool:
    """Return True if the model's speed is within the goal in every common bin."""
    largest = run["largest_speed_difference_mps"]["model"]
    return largest is not None and bool(largest <= record["goal_mps"])


def constant_rows(record: Record) -> Rows:
    """Return name and values of each fitted constant."""
    return [
        (f"`{name}`", *(shown(record[each][name]) for each in SETS)) for name in record["fitted"]
    ]


def loss_rows(record: Record) -> Rows:
    """Return the loss of each set of constants."""
    names = ", ".join(run["run"] for run in record["runs"] if run["fitted_on"])
    return [(names, *(shown(record["loss"][each]) for each in SETS))]


def speed_rows(record: Record) -> Rows:
    """Return the mean speeds of real and simulated people in every density bin."""
    rows: Rows = []
    for run in record["runs"]:
        by_side = {
            side: {each["low"]: each["speed_mps"] for each in run["sides"][side]["bins"]}
            for side in SIDES
        }
        for each in run["sides"]["real"]["bins"]:
            speeds = (shown(by_side[side].get(each["low"])) for side in SIDES)
            span = f"{shown(each['low'])} to {shown(each['high'])}"
            rows.append((_name(run), span, str(each["samples"]), *speeds))
    return rows


def difference_rows(record: Record) -> Rows:
    """Return the largest error of mean speed over the densities of each run [m/s]."""
    return [
        (_name(run), *(shown(run["largest_speed_difference_mps"][side]) for side in SIDES[1::2]))
        for run in record["runs"]
    ]


def distance_rows(record: Record) -> Rows:
    """Return counts of entered people and their mutual distances, real and simulated."""
    fields = ("people", "nearest_mean_m", "nearest_p5_m", "encountering_m", "confronting_m")
    return [
        (_name(run), side, *(shown(run["sides"][side][field]) for field in fields))
        for run in record["runs"]
        for side in ("real", "model")
    ]


def percentile_rows(record: Record) -> Rows:
    """Return the percentiles of sampled speeds, real and simulated."""
    return [
        (_name(run), side, *map(shown, run["sides"][side]["speed_percentiles_mps"]))
        for run in record["runs"]
        for side in ("real", "model")
    ]


def _verdict(record: Record) -> str:
    far = [
        run["run"] for run in record["runs"] if not run["fitted_on"] and not is_near(run, record)
    ]
    goal = shown(record["goal_mps"])
    where = f"all but {', '.join(far)}" if far else "all of them"
    return f"Within {goal} m/s on the runs not fitted on: {where}"


def _name(run: Record) -> str:
    return f"{run['run']} (fitted on)" if run["fitted_on"] else str(run["run"])
