"""Headroom results, as tables on the terminal and in Markdown."""

from __future__ import annotations

from rich.console import Group

from hazbot_gym.evaluation.oracle.headroom import (
    EXPERT_AT_MOST,
    GAS_EXPERT_AT_MOST,
    LEVELS_OF_PAPER,
    RULE_AT_MOST,
)
from hazbot_gym.evaluation.prices import PRICES, at_price
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, console_table, shown

Record = JsonObject

ROOM = (
    "environment", "fuzzy expert", "best rule", "its share", "room", "contacts at full speed",
)  # fmt: skip
UNITS = (
    "environment", "policy", "delay [s]", "discomfort [s]", "inside personal zone [m]",
    "people's delay [s]", "contacts by robot", "arrived",
    f"return at price {' / '.join(f'{price:g}' for price in PRICES)}",
)  # fmt: skip
RULES = ("environment", "rule", "return", "share of span", "with half the search")
SPEEDS = ("share of decisions", *LEVELS_OF_PAPER)
SURVEY = (
    "environment", "policy", "leaks found", "false alarms a drive", "delay [s]",
    "inside personal zone [m]", "return", "share of span",
)  # fmt: skip


def tables(record: Record) -> Group:
    """Return a record as tables for the terminal."""
    parts = [
        console_table(ROOM, _plain(room_rows(record))),
        console_table(UNITS, _plain(unit_rows(record))),
        console_table(SPEEDS, _plain(speed_rows(record))),
    ]
    if survey := survey_rows(record):
        parts.append(console_table(SURVEY, _plain(survey)))
    return Group(*parts)


def _plain(rows: Rows) -> Rows:
    return [tuple(cell.replace("`", "") for cell in row) for row in rows]


def percent(share: float) -> str:
    """Return a share in percent, without decimals."""
    return f"{100.0 * share:.0f} %"


def has_room(found: Record) -> bool:
    """Return True if the fuzzy expert and the best rule leave the intended headroom."""
    best = found["rules"][found["best_rule"]]
    limit = GAS_EXPERT_AT_MOST if "leak_found" in found["zero"] else EXPERT_AT_MOST
    return bool(found["expert"]["share"] < limit and best["share"] < RULE_AT_MOST)


def room_rows(record: Record) -> Rows:
    """Return the headroom of every environment."""
    return [
        (
            f"`{env}`",
            _share(found["expert"]),
            f"`{found['rules'][found['best_rule']]['policy']}`",
            _share(found["rules"][found["best_rule"]]),
            "yes" if has_room(found) else "no",
            percent(found["full_speed_contacts"]),
        )
        for env, found in record["environments"].items()
    ]


def unit_rows(record: Record) -> Rows:
    """Return the drives of the span's ends, the expert and the best rule, in plain units."""
    return [
        (
            f"`{env}`",
            row["policy"] if row is found["best"] else f"`{row['policy']}`",
            f"{row['delay_s']:.1f}",
            f"{row['discomfort_s']:.2f}",
            f"{row['personal_m']:.2f}",
            f"{row['person_delay_s']:.2f}",
            percent(row["contacts"]),
            percent(row["arrived"]),
            " / ".join(f"{at_price(row, price):.1f}" for price in PRICES),
        )
        for env, found in record["environments"].items()
        for row in (
            found["zero"], found["expert"], found["rules"][found["best_rule"]], found["best"],
        )
    ]  # fmt: skip


def survey_rows(record: Record) -> Rows:
    """Return the drives of every policy in environments with gas, from worst to best."""
    return [
        (
            f"`{env}`",
            row["policy"] if row is found["best"] else f"`{row['policy']}`",
            percent(row["leak_found"]),
            f"{row['false_alarms']:.3f}",
            f"{row['delay_s']:.1f}",
            f"{row['personal_m']:.2f}",
            f"{row['return']:.1f}",
            _place(row, found),
        )
        for env, found in record["environments"].items()
        if "leak_found" in found["zero"]
        for row in (
            *found["constants"], found["zero"], found["expert"],
            *sorted(found["rules"].values(), key=lambda row: row["share"]), found["best"],
        )
    ]  # fmt: skip


def rule_rows(record: Record) -> Rows:
    """Return the best member of every family of rules, and its share of the span."""
    return [
        (
            f"`{env}`",
            f"`{row['policy']}`",
            shown(row["return"]),
            _share(row),
            percent(row["share_halfway"]),
        )
        for env, found in record["environments"].items()
        for row in sorted(found["rules"].values(), key=lambda row: -row["share"])
    ]


def speed_rows(record: Record) -> Rows:
    """Return the share of decisions at each speed, of the best drives and of the expert."""
    return [
        (f"`{env}`, {who}", *map(percent, found[key]))
        for env, found in record["environments"].items()
        for who, key in (("best drive", "speeds"), ("expert", "speeds_of_expert"))
    ]


def _share(row: Record) -> str:
    low, high = (f"{100.0 * bound:.0f}" for bound in row["interval"])
    return f"{percent(row['share'])} ({low} to {high})"


def _place(row: Record, found: Record) -> str:
    """Return a row's place on the span: its ends have no interval."""
    if "share" in row:
        return _share(row)
    low, top = found["zero"]["return"], found["best"]["bound"]
    return percent((row["return"] - low) / (top - low))
