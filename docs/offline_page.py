"""The page on data sets, with the comparison of offline methods from its committed record."""

from __future__ import annotations

from string import Template

from table_text import markdown_table

from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, shown

METRICS = ("contacts_per_km", "delay_s", "personal_m")
TITLES = (
    "policy", "return", "arrived, %", "contacts by robot per km", "delay, s",
    "in the personal zone, m",
)  # fmt: skip
METHODS = {"bc": "↳ behaviour cloning", "td3_bc": "↳ TD3+BC, {updates:,} updates"}


def page(template: str, record: JsonObject, *, name: str) -> str:
    """Return the page.

    Args:
        template: With ``$`` placeholders.
        record: Of ``make_offline_record.py``.
        name: Of its file, from the root of the repository.
    """
    sizes = [run["decisions"] for run in record["runs"]]
    return Template(template).substitute(
        record=name,
        env=record["env"],
        episodes=record["episodes"],
        least=f"{min(sizes):,}",
        most=f"{max(sizes):,}",
        d3rlpy=record["versions"]["d3rlpy"],
        table=markdown_table(TITLES, rows(record["runs"])),
        longer=longer(record["runs"]),
    )


def rows(runs: list[JsonObject]) -> Rows:
    """Return the policy of each data set, followed by those trained from it."""
    found: Rows = []
    for run in runs:
        policy = f"`{run['policy']}`"
        if policy not in {row[0] for row in found}:
            found.append((policy, *_means(run["recorded"])))
        found.append((METHODS[run["method"]].format_map(run), *_means(run["trained"])))
    return found


def longer(runs: list[JsonObject]) -> str:
    """Return the returns of TD3+BC on the data set that it was trained on more than once."""
    sets = [run["dataset"] for run in runs if run["method"] == "td3_bc"]
    (name,) = {each for each in sets if sets.count(each) > 1}
    of_it = [run for run in runs if run["dataset"] == name]
    return ", ".join(
        f"{run['trained']['return']:.1f} after {run['updates']:,} updates"
        for run in of_it
        if run["method"] == "td3_bc"
    )


def _means(means: JsonObject) -> tuple[str, ...]:
    values = (100.0 * means["arrived"], *(means[name] for name in METRICS))
    return (f"{means['return']:.1f}", *map(shown, values))
