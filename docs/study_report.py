"""The studies as pages of the documentation, and the headline for the README."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from string import Template
from typing import Any

from study_record import AXIS_TITLES, OLD_AXES, TIERS, TOGETHER, axes_of
from study_targets import Target, sonar_targets, tracks_targets
from table_text import csv_table, markdown_table

from hazbot_gym.evaluation.prices import PRICES, at_price
from hazbot_gym.evaluation.statistics.pareto import AXES, dominates
from hazbot_gym.study.headline import POOLED, TEST, scenarios_of
from hazbot_gym.study.report.tables import p_text
from hazbot_gym.utils.text_tables import Rows, shown

Record = dict[str, Any]
Estimate = Mapping[str, float | None]
Column = tuple[str, str, int]

# Metric, title, digits; of those in percent the record has them so. Tables of an older record, one
# with ``study_record.OLD_AXES``, have the old columns.
HEADLINE = (
    ("delay_s", "delay, s", 2),
    ("personal_m", "in the personal zone, m", 2),
    ("intimate_m", "in the intimate zone, m", 3),
    ("person_delay_s", "people's delay, s", 2),
    ("contacts_per_km", "contacts by robot per km", 2),
    ("discomfort_s", "discomfort, s", 3),
    ("arrived", "arrived, %", 1),
    ("return", "return", 1),
)
ELSEWHERE = (
    ("delay_s", "delay, s", 2),
    ("discomfort_s", "discomfort, s", 2),
    ("contacts_per_km", "contacts by robot per km", 2),
)
OLD_HEADLINE = (
    ("arrived", "arrived, %", 1),
    ("contact_robot_caused", "contacts by robot, %", 2),
    ("time_ratio", "time ratio", 3),
    ("kinetic_intrusion_m2", "kinetic intrusion, m²", 4),
    ("ssm_violation", "SSM violation, %", 2),
    ("rms_jerk_mps3", "RMS jerk, m/s³", 2),
    ("return", "return", 1),
)
OLD_ELSEWHERE = (
    ("time_ratio", "time ratio", 3),
    ("kinetic_intrusion_m2", "kinetic intrusion, m²", 3),
    ("contact_robot_caused", "contacts by robot, %", 2),
)
FIRST_POLICIES = (  # the reference, the best tuned rules, learning on a rule and from nothing
    "fuzzy_expert",
    "fuzzy_expert, tuned",
    "ssm, tuned",
    "velocity_obstacle, tuned",
    "residual ppo on ssm",
    "ppo from nothing",
)
EXPERT = "fuzzy_expert"
NOT_IN_FIRST = ("arrived", "discomfort_s", "rms_jerk_mps3")
SHIPPED_HEADLINE = tuple(column for column in HEADLINE if column[0] != "discomfort_s")
DIRECTIONAL = "ssm:mode=directional"
LEAD = 1.0  # in return, or seconds of delay: from here a rule is named as better in a place
LEARNED = "ppo from rules"  # of the study of the shipped policy, which is its best seed
SHIPPED = "ppo"  # of the first version
RECORDED = {"replay": "replayed", "seeded": "reactive"}  # people of each set


def page(template: str, record: Record, *, name: str) -> str:
    """Return the page on the study: a template with its placeholders filled in."""
    filled = {"record": name, "answer": first_table(record), "recorded": recorded_people(record)}
    for study in ("tracks", "sonar", "observations"):
        filled |= {f"{study}_{part}": text for part, text in _parts(record[study]).items()}
    filled["tracks_targets"] = _targets(tracks_targets(record["tracks"]))
    filled["sonar_targets"] = _targets(sonar_targets(record["sonar"]))
    filled["contacts"] = _contacts(record["contacts"]["sets"][POOLED])
    filled["people"] = _people(record["people"]["sets"], _columns(record["tracks"]))
    return Template(template).substitute(filled)


def shipped_table(record: Record) -> str:
    """Return the headline for the README: learned policies and rules on the test scenarios."""
    sets = record["shipped"]["sets"]
    block, environments = sets[TEST], len(_environments(sets))
    seeds = block[LEARNED]["training_seeds"]
    note = (
        f"\nMeans over {scenarios_of(block)} test scenarios in {environments} environments, of "
        f"`{LEARNED}` also over {seeds} training seeds, from `configs/study_from_rules.yaml`."
    )
    return f"{_means(block, tuple(block), SHIPPED_HEADLINE)}\n{note}"


def shipped_prices(record: Record) -> str:
    """Return the mean return of learned policies and rules at several prices of discomfort."""
    block = record["shipped"]["sets"][TEST]
    means = {
        policy: {name: found["metrics"][name]["mean"] for name in ("return", "discomfort_s")}
        for policy, found in block.items()
    }
    titles = tuple(f"return at price {price:g}" for price in PRICES)
    rows = [
        (f"`{policy}`", *(f"{at_price(mean, price):.1f}" for price in PRICES))
        for policy, mean in means.items()
    ]
    return markdown_table(("policy", *titles), rows)


def shipped_gain(record: Record) -> str:
    """Return how the learned policies compare with the rules, together and by environment."""
    found = record["shipped"]
    sets, reference = found["sets"], found["reference"]
    block, over_expert = sets[TEST], found["over_expert"]
    gain = block[LEARNED]["return_gain"]
    higher = [f"`{policy}`" for policy, _ in _ahead(block)]
    best = {name: _ahead(policies)[:1] for name, policies in _environments(sets).items()}
    where = [
        f"`{name}-v1` (`{rule}`, by {more:.1f})"
        for name, ahead in best.items()
        for rule, more in ahead
        if more >= LEAD
    ]
    return (
        f"**In the test scenarios, `{LEARNED}` {_verdict([over_expert])} the fuzzy expert**: its "
        f"return is higher by {_estimate(over_expert, 1)}. **It {_verdict([gain])} "
        f"`{reference}`**: its return is higher by {_estimate(gain, 1)}. Rules with a higher mean "
        f"return: {', '.join(higher) or 'none'}. In single environments, by {LEAD:g} s or more: "
        f"{', '.join(where) or 'none'}."
    )


def _environments(sets: Record) -> dict[str, Record]:
    """Return the test scenarios of each environment, by its name."""
    first = f"{TEST}/"
    return {name.removeprefix(first): sets[name] for name in sets if name.startswith(first)}


def _ahead(block: Record) -> list[tuple[str, float]]:
    """Return the rules with a higher mean return than the learned policies, and how much higher."""
    means = {policy: found["metrics"]["return"]["mean"] for policy, found in block.items()}
    more = [(policy, mean - means[LEARNED]) for policy, mean in means.items()]
    return sorted((each for each in more if each[1] > 0.0), key=lambda each: -each[1])


def shield_table(record: Record) -> str:
    """Return contacts, delay and discomfort without and with a shield, on each tier."""
    sets = record["shield"]["sets"]
    columns = (
        ("contact_robot_caused", "contacts by robot, %", 3),
        ("contact_person_caused", "contacts by people, %", 2),
        ("arrived", "arrived, %", 1),
        ("delay_s", "delay, s", 1),
        ("discomfort_s", "discomfort, s", 2),
        ("return", "return", 1),
    )
    return markdown_table(
        ("tier", "policy", "episodes", *(title for _, title, _ in columns)),
        [
            (tier, f"`{policy}`", f"{found['episodes']:,}", *_cells(found, columns))
            for tier in TIERS
            for policy, found in sets[tier].items()
        ],
    )


def first_table(record: Record) -> str:
    """Return the headline of the first study: the tracks tier on its test scenarios."""
    found = record["tracks"]
    columns = [each for each in _columns(found) if each[0] not in NOT_IN_FIRST]
    block = found["together"][TEST]
    note = f"\nMeans over {scenarios_of(block)} test scenarios."
    return f"{_means(block, FIRST_POLICIES, columns)}\n{note}"


def recorded_people(record: Record) -> str:
    """Return the gain of the shipped policy over its base rule among recorded people, as text."""
    people = record["people"]
    gains = {
        name: people["sets"][f"real people, {name}"][SHIPPED]["return_gain"] for name in RECORDED
    }
    verdict = _verdict(gains.values())
    shown_gains = " and ".join(
        f"{_estimate(gains[name], 1)} with {what}" for name, what in RECORDED.items()
    )
    return (
        f"**Among people recorded in real corridors, `{SHIPPED}` {verdict} its base rule**: "
        f"the paired difference in return to `{people['reference']}` is {shown_gains} "
        "people."
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


def _verdict(gains: Collection[Mapping[str, float]]) -> str:
    """Return how paired differences in return compare with zero, by their intervals."""
    if all((gain["high"] or 0.0) < 0.0 for gain in gains):
        return "earns less than"
    if all((gain["low"] or 0.0) > 0.0 for gain in gains):
        return "earns more than"
    return "does not clearly earn more than"


def _means(block: Record, policies: Sequence[str], columns: Sequence[Column]) -> str:
    return markdown_table(
        ("policy", *(title for _, title, _ in columns)),
        [
            (f"`{policy}`", *_cells(block[policy], columns, with_interval=False))
            for policy in policies
        ],
    )


def _parts(found: Record) -> dict[str, str]:
    test = found["together"][TEST]
    reference = found["reference"]
    return {
        "episodes": str(scenarios_of(test)),
        "reference": f"`{reference}`",
        "commit": f"`{(found['commit'] or '')[:12]}`",
        "machine": f"{found['machine']['processor']}, {found['machine']['cores']} cores",
        "headline": _headline(found, found["policies"]),
        "differences": _differences(found, reference),
        "tails": _tails(found),
        "sets": _sets(found),
        "fronts": _fronts(found),
        "elsewhere": _elsewhere(found),
        "directional": _beaten_by_directional(found),
        "learners": _learners(found),
        "tuned": _tuned(found),
        "sessions": _sessions(found),
        "exact": _regrets(found, "exact"),
        "searched": _regrets(found, "searched"),
    }


def _columns(found: Record) -> tuple[Column, ...]:
    return HEADLINE if axes_of(found) == AXES else OLD_HEADLINE


def _headline(found: Record, policies: Sequence[str]) -> str:
    block, columns = found["together"][TEST], _columns(found)
    titles = ("policy", "seeds", *(title for _, title, _ in columns))
    return markdown_table(
        titles,
        [
            (f"`{policy}`", str(block[policy]["training_seeds"]), *_cells(block[policy], columns))
            for policy in policies
        ],
    )


def _cells(
    found: Record, columns: Sequence[Column], *, with_interval: bool = True
) -> Iterator[str]:
    for metric, title, digits in columns:
        kind = "percent" if title.endswith("%") else "metrics"
        yield _estimate(found[kind][metric], digits, with_interval=with_interval)


def _differences(found: Record, reference: str) -> str:
    axes, block = axes_of(found), found["together"][TEST]
    floor = _floor(block) if axes == OLD_AXES else 0.0
    compared = (title for axis in axes for title in (AXIS_TITLES[axis], "p"))
    rows: Rows = []
    for policy in found["policies"]:
        if policy == reference:
            continue
        each, gain = block[policy]["difference"], block[policy]["return_gain"]
        cells = ((_estimate(each[axis], 4), _p(each[axis], floor)) for axis in axes)
        rows.append(
            (
                f"`{policy}`",
                *itertools.chain.from_iterable(cells),
                _estimate(gain, 2),
                _estimate(gain["probability"], 3),
            )
        )
    return markdown_table(("policy", *compared, "return", "probability of improvement"), rows)


def _floor(block: Record) -> float:
    """Return the smallest p-value, which counted resamples give to every clear difference."""
    compared = [each for policy in block.values() for each in policy["difference"].values()]
    return float(min(each["p"] for each in compared))


def _p(difference: Record, floor: float) -> str:
    """Return a corrected p-value; as a bound if the uncorrected one is the floor."""
    p = difference["p_holm"]
    if p is None:
        return "-"
    return f"<= {p:.2g}" if difference["p"] == floor else p_text(p).removeprefix("= ")


def _tails(found: Record) -> str:
    block, nearness = found["together"][TEST], axes_of(found)[1]
    metrics = (
        ("clearance_min_m", "least clearance, m", 3),
        ("ttc_min_s", "least time to collision, s", 2),
        (nearness, AXIS_TITLES[nearness], 3),
    )
    return markdown_table(
        ("policy", *(title for _, title, _ in metrics)),
        [
            (
                f"`{policy}`",
                *(_estimate(block[policy]["tails"][name], digits) for name, _, digits in metrics),
            )
            for policy in found["shown"]
        ],
    )


def _sets(found: Record) -> str:
    columns = [column for column in _columns(found) if column[0] in axes_of(found)]
    return markdown_table(
        ("scenarios", "policy", *(title for _, title, _ in columns)),
        [
            (name, f"`{policy}`", *_cells(found["sets"][name][policy], columns))
            for name in found["sets"]
            for policy in found["shown"]
        ],
    )


def _fronts(found: Record) -> str:
    if not found["fronts"]:
        return ""
    families = found["fronts"][TOGETHER]
    largest = max(families.values(), key=lambda each: each["hypervolume"]["mean"])
    return markdown_table(
        ("family", "points", "hypervolume", "more than the fuzzy expert's", "largest"),
        [
            (
                f"`{family}`",
                str(len(each["points"])),
                _estimate(each["hypervolume"], 4),
                _estimate(each["difference"], 4),
                "yes" if each is largest else "tie" if _is_tie(each, largest) else "no",
            )
            for family, each in families.items()
        ],
    )


def _is_tie(family: Record, largest: Record) -> bool:
    """Return True if a hypervolume is not clearly less than the largest.

    An old record has no paired differences from the largest; there, intervals that overlap tie.
    """
    if "behind" in family:
        return bool(family["behind"]["high"] >= 0.0)
    return bool(family["hypervolume"]["high"] >= largest["hypervolume"]["low"])


def _elsewhere(found: Record) -> str:
    columns = OLD_ELSEWHERE if axes_of(found) != AXES else ELSEWHERE
    titles = ("scenarios", "policy", *(title for _, title, _ in columns))
    return markdown_table(
        titles,
        [
            (group, f"`{policy}`", *_cells(block[policy], columns))
            for group, block in found["together"].items()
            if group != TEST
            for policy in found["shown"]
        ],
    )


def _beaten_by_directional(found: Record) -> str:
    """Return where directional SSM beats a learned policy on both axes."""
    lines = [
        f"- {group}: `{policy}`"
        for group, block in found["together"].items()
        for policy in found["learners"]
        if dominates(block[DIRECTIONAL]["metrics"], block[policy]["metrics"], axes_of(found))
    ]
    return "\n".join(lines) or "- nowhere"


def _contacts(block: Record) -> str:
    columns = (
        ("contact_robot_caused", "contacts by robot, %", 3),
        ("contact_person_caused", "contacts by people, %", 2),
    )
    return markdown_table(
        ("policy", "episodes", *(title for _, title, _ in columns)),
        [
            (f"`{policy}`", str(found["episodes"]), *_cells(found, columns))
            for policy, found in block.items()
        ],
    )


def _people(sets: Record, columns: Sequence[Column]) -> str:
    return markdown_table(
        ("scenarios", "policy", *(title for _, title, _ in columns)),
        [
            (name, f"`{policy}`", *_cells(found, columns))
            for name, block in sets.items()
            if name.startswith("real people")
            for policy, found in block.items()
        ],
    )


def _learners(found: Record) -> str:
    return markdown_table(
        ("learner", "file", "seeds", "decisions", "seconds a run", "return on validation"),
        [
            (
                f"`{each['name']}`",
                f"`{each['config']}`",
                str(each["seeds"]),
                str(each["decisions"]),
                shown(each["seconds"]),
                f"{each['validation_return']:.1f}",
            )
            for each in found["trainings"]
        ],
        wordy=("file",),
    )


def _tuned(found: Record) -> str:
    return markdown_table(
        ("policy", "options found", "at a bound"),
        [
            (f"`{name}`", f"`{each['policy']}`", ", ".join(each["at_a_bound"]) or "-")
            for name, each in found["tuned"].items()
        ],
        wordy=("options found", "at a bound"),
    )


def _sessions(found: Record) -> str:
    return "\n".join(
        f"- `{each['command']}`: {shown(each['seconds'])} s, at most "
        f"{shown(each['peak_memory_gb'])} GB in a process, {each['prepared']} searches and "
        f"training runs, {each['shards']} shards of episodes, {each['decisions']} decisions."
        for each in found["sessions"]
    )


def _regrets(found: Record, kind: str) -> str:
    block = found["oracle"].get(kind)
    if block is None:
        return ""
    delay = (("avoidable_delay_s", "avoidable delay, s", 2),)
    if axes_of(found) != AXES:
        delay = (("avoidable_delay", "avoidable delay", 4),)
    columns = (
        ("regret", "regret", 2),
        ("normalised", "of the span, %", 1),
        *delay,
    )
    return markdown_table(
        ("policy", *(title for _, title, _ in columns)),
        [
            (
                f"`{policy}`",
                *(
                    _estimate(block["policies"][policy][name], digits)
                    for name, _, digits in columns
                ),
            )
            for policy in found["policies"]
        ],
    )


def _targets(targets: Sequence[Target]) -> str:
    return markdown_table(
        ("to reach", "measured", "reached"),
        [(each.aim, each.measured, "yes" if each.is_reached else "**no**") for each in targets],
        wordy=("measured",),
    )


def _estimate(estimate: Estimate, digits: int, *, with_interval: bool = True) -> str:
    mean, low, high = (estimate[end] for end in ("mean", "low", "high"))
    if mean is None:
        return "-"
    text = f"{mean:z.{digits}f}"
    if not with_interval or low is None or high is None:
        return text
    return f"{text} ({low:z.{digits}f} to {high:z.{digits}f})"
