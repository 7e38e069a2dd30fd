"""The page on every algorithm with ten seeds, and README's table, from ``benchmarks/full.json``."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from string import Template

from table_text import estimate_text, markdown_table

from hazbot_gym.study.default_policies import family_of
from hazbot_gym.study.headline import scenarios_of
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, shown

Record = JsonObject

REAL = {"real people, replay": "as recorded", "real people, seeded": "reactive"}
TITLES = (
    "policy",
    "return",
    "difference to the best rule",
    "probability of improvement",
    "delay, s",
    "discomfort, s",
    "arrived, %",
    "contacts by robot per km",
    "training, s",
)
REAL_TITLES = (
    "policy",
    "people",
    "return",
    "difference to the expert",
    "delay, s",
    "people's delay, s",
    "discomfort, s",
    "contacts by robot per km",
)
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


def page(template: str, record: Record, *, name: str, search: Record) -> str:
    """Return the page: a template with its placeholders filled in.

    Args:
        template: With ``$`` placeholders.
        record: Of ``docs/keep_full.py``.
        name: Of its file, from the root of the repository.
        search: Record of ``docs/keep_search.py``.
    """
    block = record["sets"][record["headline"]]
    seconds = sum(session["seconds"] for session in record["sessions"])
    return Template(template).substitute(
        record=name,
        processor=record["machine"]["processor"],
        cores=record["machine"]["cores"],
        scenarios=scenarios_of(block),
        seeds=_seeds(record),
        learners=len(record["runs"]),
        best_rule=record["best_rule"],
        table=_table(record),
        ahead=_named(ahead_of_best_rule(record)),
        above=_above(record),
        environments=_environments(record),
        real=_real(record),
        real_ahead=_real_ahead(record),
        exact=_exact(record),
        trials=len(next(iter(search.values()))["trials"]),
        searches=_searches(search),
        tuned="\n".join(f"- `{spec}`" for spec in record["tuned"].values()),
        hours=f"{seconds / 3600:.1f}",
        sessions=len(record["sessions"]),
    )


def readme_table(record: Record) -> str:
    """Return the table for the README: rules and learners, best first, real people beside."""
    block = record["sets"][record["headline"]]
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
            *(f"{_return(record['sets'][name][policy]):z.1f}" for name in REAL),
        )
        for policy in _ranked(block)
        if policy in (*_best_of_family(record), *_learned(record))
    ]
    recorded = scenarios_of(record["sets"][next(iter(REAL))])
    return (
        f"{markdown_table(README_TITLES, rows)}\n\nMeans over {scenarios_of(block)} test "
        f"scenarios in {len(_places(record))} environments, and over {recorded} drives among "
        f"people recorded in corridors and streets, of learners also over {_seeds(record)} "
        "training seeds, from `configs/study_full.yaml`."
    )


def readme_text(record: Record) -> str:
    """Return what the table says of learners and rules, in the test scenarios and elsewhere."""
    ahead = _named(ahead_of_best_rule(record))
    return (
        "**In the test scenarios, these policies earn more than the best tuned rule** "
        f"(`{record['best_rule']}`), by the interval of the paired difference: {ahead}. "
        f"{_real_ahead(record)}"
    )


def ahead_of_best_rule(record: Record) -> list[str]:
    """Return the learned policies with an interval above 0 over the best rule, best first."""
    gains = record["over_best_rule"]
    return [
        policy
        for policy in _ranked(gains, key=lambda policy: gains[policy]["mean"])
        if policy in _learned(record) and gains[policy]["low"] > 0.0
    ]


def _table(record: Record) -> str:
    block, gains = record["sets"][record["headline"]], record["over_best_rule"]
    rows: Rows = []
    for policy in _ranked(block):
        metrics, gain = block[policy]["metrics"], gains[policy]
        is_best = policy == record["best_rule"]
        rows.append(
            (
                f"`{policy}`",
                estimate_text(metrics["return"]),
                "" if is_best else estimate_text(gain),
                "" if is_best else estimate_text(gain["probability"], 2),
                shown(metrics["delay_s"]["mean"]),
                shown(metrics["discomfort_s"]["mean"]),
                shown(100.0 * metrics["arrived"]["mean"]),
                shown(metrics["contacts_per_km"]["mean"]),
                _seconds(record, policy),
            )
        )
    return markdown_table(TITLES, rows)


def _above(record: Record) -> str:
    """Return, for each learner, how many seeds are above the expert and above the best rule."""
    block, runs = record["sets"][record["headline"]], record["runs"]
    bars = [_return(block[policy]) for policy in (record["reference"], record["best_rule"])]
    return markdown_table(
        ("learner", "seeds", "above the expert", "above the best rule", "lowest", "highest"),
        [
            (
                f"`{learner}`",
                str(len(returns)),
                *(str(sum(each > bar for each in returns)) for bar in bars),
                f"{min(returns):.1f}",
                f"{max(returns):.1f}",
            )
            for learner in _ranked(runs, key=lambda learner: _return(block[learner]))
            if (returns := [run["return"] for run in runs[learner]])
        ],
    )


def _environments(record: Record) -> str:
    """Return the mean return of each policy in each environment, the best rule's and more bold."""
    places = _places(record)
    bars = {
        place: max(_return(block[rule]) for rule in record["rules"])
        for place, block in places.items()
    }

    def cell(policy: str, place: str) -> str:
        mean = _return(places[place][policy])
        return f"**{mean:.1f}**" if mean >= bars[place] else f"{mean:.1f}"

    policies = _ranked(record["sets"][record["headline"]])
    return markdown_table(
        ("policy", *places),
        [(f"`{policy}`", *(cell(policy, place) for place in places)) for policy in policies],
    )


def _real(record: Record) -> str:
    rows: Rows = []
    for name, what in REAL.items():
        block = record["sets"][name]
        for policy in _ranked(block):
            metrics = block[policy]["metrics"]
            gain = block[policy]["return_gain"]
            rows.append(
                (
                    f"`{policy}`",
                    what,
                    estimate_text(metrics["return"]),
                    "" if policy == record["reference"] else estimate_text(gain),
                    *(
                        shown(metrics[metric]["mean"])
                        for metric in (
                            "delay_s",
                            "person_delay_s",
                            "discomfort_s",
                            "contacts_per_km",
                        )
                    ),
                )
            )
    return markdown_table(REAL_TITLES, rows, wordy=("people",))


def _real_ahead(record: Record) -> str:
    """Return which rules have a higher mean return than each learner, among real people."""
    sentences = []
    for name, what in REAL.items():
        block = record["sets"][name]
        best = max(record["rules"], key=lambda rule: _return(block[rule]))
        learned = _learned(record)
        above = [policy for policy in learned if _return(block[policy]) > _return(block[best])]
        clear = [policy for policy in learned if block[policy]["return_gain"]["low"] > 0.0]
        worse = [policy for policy in learned if block[policy]["return_gain"]["high"] < 0.0]
        sentences.append(
            f"Among real people {what}, the best rule is `{best}` ({_return(block[best]):.1f}); "
            f"learned policies with a higher mean: {_named(above)}. Compared with "
            f"`{record['reference']}`, clearly better are {_named(clear)}, clearly worse "
            f"{_named(worse)}."
        )
    return " ".join(sentences)


def _exact(record: Record) -> str:
    shares = record["oracle"]
    return markdown_table(
        ("policy", "share, %"),
        [
            (f"`{policy}`", estimate_text(shares[policy], scale=100.0))
            for policy in _ranked(shares, key=lambda policy: shares[policy]["mean"])
        ],
    )


def _searches(search: Record) -> str:
    """Return the trials of each search: the return of its file's own values, and of the best."""
    rows: Rows = []
    for name, found in search.items():
        trials = found["trials"]
        best = trials[found["best"]]
        values = ", ".join(f"{key} {_short(value)}" for key, value in best["values"].items())
        rows.append(
            (
                f"`{name}`",
                f"{trials[0]['return']:.1f}",
                f"{best['return']:.1f}",
                f"{min(trial['return'] for trial in trials):.1f}",
                f"{best['steps']:,}",
                "as in the file" if found["best"] == 0 else f"`{values}`",
            )
        )
    titles = ("search", "own values", "best", "worst", "steps of the best", "values of the best")
    return markdown_table(titles, rows, wordy=titles[-1:])


def _short(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _learned(record: Record) -> list[str]:
    block = record["sets"][record["headline"]]
    return [policy for policy in block if policy not in record["rules"]]


def _best_of_family(record: Record) -> list[str]:
    """Return the rule with the highest mean return of each family, and the reference."""
    block, best = record["sets"][record["headline"]], {}
    for rule in reversed(_ranked({rule: block[rule] for rule in record["rules"]})):
        best[family_of(rule)] = rule
    return [record["reference"], *best.values()]


def _places(record: Record) -> Record:
    """Return the test scenarios of each environment, by its name."""
    first = f"{record['headline']}/"
    sets = record["sets"]
    return {name.removeprefix(first): sets[name] for name in sets if name.startswith(first)}


def _ranked(block: Record, key: object = None) -> list[str]:
    """Return the names in a block, the highest mean return first."""
    rank = key if callable(key) else lambda policy: _return(block[policy])
    return sorted(block, key=lambda policy: -rank(policy))


def _return(found: Record) -> float:
    return float(found["metrics"]["return"]["mean"])


def _seconds(record: Record, policy: str) -> str:
    """Return the median time of a learner's trainings."""
    runs = record["runs"].get(policy, ())
    return f"{statistics.median(run['training_seconds'] for run in runs):.0f}" if runs else ""


def _seeds(record: Record) -> int:
    return len(next(iter(record["runs"].values())))


def _named(policies: Iterable[str]) -> str:
    return ", ".join(f"`{policy}`" for policy in policies) or "none"
