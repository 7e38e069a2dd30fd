"""The page on one policy for every price of nearness, from its committed record."""

from __future__ import annotations

from itertools import pairwise
from string import Template

from table_text import markdown_table

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, shown

TITLES = (
    "policy",
    "delay, s",
    "discomfort, s",
    "in the personal zone, m",
    "arrived, %",
    "contacts by robot per km",
)


def page(template: str, record: JsonObject, *, name: str) -> str:
    """Return the page.

    Args:
        template: With ``$`` placeholders.
        record: Of ``make_prices_record.py``.
        name: Of its file, from the root of the repository.
    """
    training = record["training"]
    decisions = training["steps"] * training["action_repeat"] / 1e6
    environments = len(record["environments"])
    return Template(template).substitute(
        record=name,
        environments=environments,
        episodes=environments * record["episodes"],
        decisions=f"{decisions:.0f}",
        seed=training["seed"],
        exchanged=", ".join(f"{rate:.1f}" for rate in exchange_rates(record)),
        points=markdown_table(TITLES, [_row(each) for each in (*record["prices"], record["ppo"])]),
        best=markdown_table(
            ("price", "`ppo_prices`", "`ppo`", "best rule", "its return"), list(_best(record))
        ),
    )


def _row(point: JsonObject) -> tuple[str, ...]:
    names = ("delay_s", "discomfort_s", "personal_m")
    values = (*(point[name] for name in names), 100.0 * point["arrived"], point["contacts_per_km"])
    return (f"`{point['policy']}`", *map(shown, values))


def exchange_rates(record: JsonObject) -> list[float]:
    """Return the delay paid for less discomfort from each price to the next one [s/s]."""
    return [
        (dear["delay_s"] - cheap["delay_s"]) / (cheap["discomfort_s"] - dear["discomfort_s"])
        for cheap, dear in pairwise(record["prices"])
    ]


def _best(record: JsonObject) -> Rows:
    """Return, for each price, the returns of the policy at it and of the best value of any rule."""
    swept = [point for points in record["rules"].values() for point in points]
    found: Rows = []
    for own in record["prices"]:
        price = f"{own['price']:g}"
        best = max(swept, key=lambda point: point["returns"][price])
        returns = (each["returns"][price] for each in (own, record["ppo"], best))
        mine, plain, theirs = (f"{value:.1f}" for value in returns)
        found.append((price, mine, plain, f"`{best['policy']}`", theirs))
    return found
