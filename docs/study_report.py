"""Tables and sentences from the studies of the shipped policy, ``benchmarks/study.json``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from table_text import csv_table, estimate_text, markdown_table, verdict

from hazbot_gym.evaluation.prices import PRICES, at_price
from hazbot_gym.study.headline import TEST, scenarios_of
from hazbot_gym.utils.json_object import JsonObject

STUDY = Path(__file__).parents[1] / "benchmarks" / "study.json"
Record = JsonObject
Column = tuple[str, str, int]  # metric, title, digits; a rate is shown in percent where titled so

HEADLINE: tuple[Column, ...] = (
    ("delay_s", "delay, s", 2),
    ("personal_m", "in the personal zone, m", 2),
    ("intimate_m", "in the intimate zone, m", 3),
    ("person_delay_s", "people's delay, s", 2),
    ("contacts_per_km", "contacts by robot per km", 2),
    ("arrived", "arrived, %", 1),
    ("return", "return", 1),
)
SHIELD: tuple[Column, ...] = (
    ("contact_robot_caused", "contacts by robot, %", 3),
    ("contact_person_caused", "contacts by people, %", 2),
    ("arrived", "arrived, %", 1),
    ("delay_s", "delay, s", 1),
    ("discomfort_s", "discomfort, s", 2),
    ("return", "return", 1),
)
MANY: tuple[Column, ...] = (
    ("delay_s", "delay, s", 1),
    ("discomfort_s", "discomfort, s", 2),
    ("person_delay_s", "people's delay, s", 1),
    ("contact_robot_caused", "contacts by robot, %", 3),
    ("arrived", "arrived, %", 1),
)
LEARNED = "ppo from rules"  # the shipped policy is one such training
TIERS = ("tracks", "sonar")  # of the study of the shield
LEAD = 1.0  # in return, or seconds of delay: from here a rule is named as better in a place


def shipped_table(record: Record) -> str:
    """Return means of learned policies and rules on the test scenarios."""
    sets = record["shipped"]["sets"]
    block, environments = sets[TEST], len(_environments(sets))
    seeds = block[LEARNED]["training_seeds"]
    table = markdown_table(
        ("policy", *(title for _, title, _ in HEADLINE)),
        [
            (f"`{policy}`", *(cell.partition(" (")[0] for cell in _cells(found, HEADLINE)))
            for policy, found in block.items()
        ],
    )
    return (
        f"{table}\n\nMeans over {scenarios_of(block)} test scenarios in {environments} "
        f"environments, of `{LEARNED}` also over {seeds} training seeds, from "
        "`configs/study_from_rules.yaml`."
    )


def shipped_prices(record: Record) -> str:
    """Return the mean return of learned policies and rules at several prices of discomfort."""
    means = {
        policy: {name: found["metrics"][name]["mean"] for name in ("return", "discomfort_s")}
        for policy, found in record["shipped"]["sets"][TEST].items()
    }
    return markdown_table(
        ("policy", *(f"return at price {price:g}" for price in PRICES)),
        [
            (f"`{policy}`", *(f"{at_price(mean, price):.1f}" for price in PRICES))
            for policy, mean in means.items()
        ],
    )


def shipped_gain(record: Record) -> str:
    """Return how the learned policies compare with the rules, together and by environment."""
    found = record["shipped"]
    sets, reference, over_expert = found["sets"], found["reference"], found["over_expert"]
    gain, returns = sets[TEST][LEARNED]["return_gain"], found["returns"]
    mean = sets[TEST][reference]["metrics"]["return"]["mean"]
    higher = [f"`{policy}`" for policy, _ in _ahead(sets[TEST])]
    best = {name: _ahead(policies)[:1] for name, policies in _environments(sets).items()}
    where = [
        f"`{name}-v1` (`{rule}`, by {more:.1f})"
        for name, ahead in best.items()
        for rule, more in ahead
        if more >= LEAD
    ]
    return (
        f"**In the test scenarios, `{LEARNED}` {verdict(over_expert)} the fuzzy expert**: its "
        f"return is higher by {estimate_text(over_expert)}. **It {verdict(gain)} "
        f"`{reference}`**: its return is higher by {estimate_text(gain)}. Of its {len(returns)} "
        f"seeds {sum(each > mean for each in returns)} have a higher mean return than that rule; "
        f"the lowest has {min(returns):.1f}, the highest {max(returns):.1f}. Rules with a higher "
        f"mean return: {', '.join(higher) or 'none'}. In single environments, by {LEAD:g} s or "
        f"more: {', '.join(where) or 'none'}."
    )


def many_table(record: Record) -> str:
    """Return the shipped policy and rules in many scenarios, and ``many_text``."""
    block = record["many"]["sets"]["tracks"]
    columns = (*MANY, ("return", "return", 1))
    table = markdown_table(
        ("policy", *(title for _, title, _ in columns)),
        [(f"`{policy}`", *_cells(each, columns)) for policy, each in block.items()],
    )
    return f"{table}\n\n{many_text(record)}"


def many_text(record: Record) -> str:
    """Return whether the shipped policy is ahead of the best rule in many scenarios."""
    found = record["many"]
    block, reference = found["sets"]["tracks"], found["reference"]
    gain = block["ppo"]["return_gain"]
    return (
        f"In {scenarios_of(block):,} further scenarios, the shipped `ppo` {verdict(gain)} "
        f"`{reference}`: its return is higher by {estimate_text(gain)} s."
    )


def shield_table(record: Record) -> str:
    """Return contacts, delay and discomfort without and with a shield, in each set."""
    sets = record["shield_test"]["sets"] | record["shield"]["sets"]
    return markdown_table(
        ("scenarios", "policy", "episodes", *(title for _, title, _ in SHIELD)),
        [
            (name, f"`{policy}`", f"{found['episodes']:,}", *_cells(found, SHIELD))
            for name in (TEST, *TIERS)
            for policy, found in sets[name].items()
        ],
    )


def csv_of(sets: Record) -> str:
    """Return mean and interval of each metric of each policy in each set of scenarios, as CSV."""
    ends = ("mean", "low", "high")
    return csv_table(
        ("scenarios", "policy", "metric", *ends),
        [
            (name, policy, metric, *(estimate[end] for end in ends))
            for name, policies in sets.items()
            for policy, found in policies.items()
            for metric, estimate in found["metrics"].items()
        ],
    )


def _environments(sets: Record) -> Record:
    """Return the test scenarios of each environment, by its name."""
    first = f"{TEST}/"
    return {name.removeprefix(first): sets[name] for name in sets if name.startswith(first)}


def _ahead(block: Record) -> list[tuple[str, float]]:
    """Return the rules with a higher mean return than the learned policies, and how much higher."""
    means = {policy: found["metrics"]["return"]["mean"] for policy, found in block.items()}
    more = [(policy, mean - means[LEARNED]) for policy, mean in means.items()]
    return sorted((each for each in more if each[1] > 0.0), key=lambda each: -each[1])


def _cells(found: Record, columns: Sequence[Column]) -> Iterator[str]:
    for metric, title, digits in columns:
        scale = 100.0 if title.endswith("%") else 1.0
        yield estimate_text(found["metrics"][metric], digits, scale=scale)
