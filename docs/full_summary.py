"""README's table and the answer to the paper's question, from ``benchmarks/full.json``."""

from __future__ import annotations

from full_record import (
    REAL,
    Record,
    ahead_of_best_rule,
    best_of_family,
    headline,
    in_each_place,
    leader,
    learned_in,
    means,
    named,
    ranked,
    return_of,
    seeds_of,
)
from study_report import many_text
from table_text import estimate_text, markdown_table, verdict

from hazbot_gym.study.default_policies import CONSTANT, family_of
from hazbot_gym.study.headline import scenarios_of

MOST_LEARNERS = 4  # in the README's table
README_TITLES = (
    "policy",
    "return",
    "delay, s",
    "in the personal zone, m",
    "people's delay, s",
    "contacts by robot per km",
    "arrived, %",
    *(f"return, real people {what}" for what in REAL.values()),
)


def readme_table(record: Record) -> str:
    """Return the table for the README: rules and the best learners, real people beside."""
    block = headline(record)
    learned = [policy for policy in ranked(block) if policy in learned_in(record)]
    shown_policies = {*best_of_family(record), *learned[:MOST_LEARNERS]}
    rows = [
        (
            f"`{policy}`",
            *(
                f"{block[policy]['metrics'][metric]['mean']:z.{digits}f}"
                for metric, digits in (("return", 1), ("delay_s", 1), ("personal_m", 2))
            ),
            f"{block[policy]['metrics']['person_delay_s']['mean']:.1f}",
            f"{block[policy]['metrics']['contacts_per_km']['mean']:.2f}",
            f"{100.0 * block[policy]['metrics']['arrived']['mean']:.1f}",
            *(f"{return_of(record['sets'][name][policy]):z.1f}" for name in REAL),
        )
        for policy in ranked(block)
        if policy in shown_policies and family_of(policy) != CONSTANT
    ]
    recorded = scenarios_of(record["sets"][next(iter(REAL))])
    return (
        f"{markdown_table(README_TITLES, rows)}\n\nMeans over {scenarios_of(block)} test "
        f"scenarios in {len(in_each_place(record))} environments, and over {recorded} drives among "
        f"people recorded in corridors and streets, of learners also over {seeds_of(record)} "
        "training seeds, from `configs/study_full.yaml`. Of each family of rules the better of "
        f"tuned and default options; [all {len(learned_in(record))} learned policies]"
        "(docs/algorithms.md)."
    )


def readme_text(record: Record) -> str:
    """Return what the table says of learners and rules, in the test scenarios and elsewhere."""
    real = "; ".join(
        f"{what} {leader(block, record['rules'])} and {leader(block, learned_in(record))}"
        for name, what in REAL.items()
        if (block := record["sets"][name])
    )
    return (
        "**Clearly ahead of the best tuned rule in the test scenarios** "
        f"(`{record['best_rule']}`): {named(ahead_of_best_rule(record))}. The best rule and the "
        f"best learned policy among real people: {real}."
    )


def answer(record: Record, study: Record) -> str:
    """Return the answer to the paper's question in three sentences, for whoever has a robot.

    Args:
        record: Of ``docs/keep_full.py``.
        study: Of ``docs/keep_study.py``: contacts, and many scenarios.
    """
    block, reference, rule = headline(record), record["reference"], record["best_rule"]
    best = next(policy for policy in ranked(block) if policy in learned_in(record))
    own, expert = (means(block[policy]) for policy in (best, reference))
    over_expert, over_rule = block[best]["return_gain"], record["over_best_rule"][best]
    clear = [learner for learner in record["runs"] if block[learner]["return_gain"]["low"] > 0.0]
    ahead = [learner for learner in ahead_of_best_rule(record) if learner in record["runs"]]
    crowd = record["sets"]["real people, seeded"]
    sonar = study["shield"]["sets"]["sonar"]["ppo"]["metrics"]["contact_robot_caused"]["mean"]
    return (
        f"1. Where people are tracked, a learned speed policy, `{best}`, {verdict(over_expert)} "
        f"the fuzzy expert ({estimate_text(over_expert)} s): {own['delay_s']:.1f} s of delay a "
        f"drive instead of {expert['delay_s']:.1f} s, {own['person_delay_s']:.1f} s of delay for "
        f"people instead of {expert['person_delay_s']:.1f} s, for {own['personal_m']:.1f} m "
        f"instead of {expert['personal_m']:.1f} m driven within 1.2 m of somebody.\n"
        f"2. In these {scenarios_of(block)} test scenarios it {verdict(over_rule)} the best tuned "
        f"rule, `{rule}` ({estimate_text(over_rule)} s). "
        f"{many_text(study)} Of {len(record['runs'])} learners with {seeds_of(record)} seeds of a "
        f"minute each, those that clearly earn more than the expert are {named(clear)}, and more "
        f"than that rule {named(ahead)}.\n"
        f"3. Among recorded people who react, the best rule is {leader(crowd, record['rules'])}, "
        f"the best learned policy {leader(crowd, learned_in(record))}, and with four sonars alone "
        f"the shipped policy causes a contact in {100 * sonar:.1f} % of the drives: track people, "
        "or use other sensors, before it drives among them."
    )
