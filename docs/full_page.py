"""The page on every algorithm with ten seeds, from ``benchmarks/full.json``."""

from __future__ import annotations

from string import Template

from full_record import (
    REAL,
    Record,
    ahead_of_best_rule,
    headline,
    in_each_place,
    leader,
    learned_in,
    named,
    ranked,
    return_of,
    seconds,
    seeds_of,
)
from learning_page import policies_table
from table_text import estimate_text, markdown_table

from hazbot_gym.study.headline import scenarios_of
from hazbot_gym.utils.text_tables import Rows, shown

FAR = 20.0  # in return: from here a seed crawls, stands or drives too fast
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


def page(template: str, record: Record, *, name: str, search: Record, slow: Record) -> str:
    """Return the page: a template with its placeholders filled in.

    Args:
        template: With ``$`` placeholders.
        record: Of ``docs/keep_full.py``.
        name: Of its file, from the root of the repository.
        search: Record of ``docs/keep_search.py``.
        slow: Record of the slowest learners, of ``docs/keep_learning.py``.
    """
    block = headline(record)
    runs = [run for seeds in record["runs"].values() for run in seeds]
    session = record["sessions"][-1]
    medians = sorted((seconds(record, learner) for learner in record["runs"]), key=int)
    return Template(template).substitute(
        record=name,
        processor=record["machine"]["processor"],
        cores=record["machine"]["cores"],
        scenarios=scenarios_of(block),
        seeds=seeds_of(record),
        learners=len(record["runs"]),
        best_rule=record["best_rule"],
        table=_table(record),
        ahead=named(ahead_of_best_rule(record)),
        above=_above(record),
        trapped=_trapped(record),
        environments=_environments(record),
        real=_real(record),
        real_ahead=real_people(record),
        exact=_exact(record),
        trials=len(next(iter(search.values()))["trials"]),
        searches=_searches(search),
        slow_table=policies_table(slow),
        slow_scenarios=slow["episodes"],
        slow_above=_seeds_above(slow),
        tuned="\n".join(f"- `{spec}`" for spec in record["tuned"].values()),
        trainings=len(runs),
        least_s=medians[0],
        most_s=medians[-1],
        core_hours=f"{sum(run['training_seconds'] for run in runs) / 3600:.1f}",
        minutes=f"{session['seconds'] / 60:.0f}",
        prepared=session["prepared"],
        shards=session["shards"],
    )


def _table(record: Record) -> str:
    block, gains = headline(record), record["over_best_rule"]
    rows: Rows = []
    for policy in ranked(block):
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
                seconds(record, policy),
            )
        )
    return markdown_table(TITLES, rows)


def _seeds_above(slow: Record) -> str:
    """Return how many seeds of the slowest learners have a higher mean return than the expert."""
    expert = slow["policies"][slow["reference"]]["return"]["mean"]
    returns = [run["return"] for runs in slow["runs"].values() for run in runs]
    return f"{sum(each > expert for each in returns)} of {len(returns)}"


def _above(record: Record) -> str:
    """Return, for each learner, how many seeds are above the expert and above the best rule."""
    block, runs = headline(record), record["runs"]
    bars = [return_of(block[policy]) for policy in (record["reference"], record["best_rule"])]
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
            for learner in ranked({name: block[name] for name in runs})
            if (returns := [run["return"] for run in runs[learner]])
        ],
    )


def _trapped(record: Record) -> str:
    """Return how many seeds of which learners end far below the expert."""
    expert = return_of(headline(record)[record["reference"]])
    counts = {
        learner: sum(run["return"] < expert - FAR for run in runs)
        for learner, runs in record["runs"].items()
    }
    found = ", ".join(f"`{learner}` {count}" for learner, count in counts.items() if count)
    return f"more than {FAR:g} below the expert: {found or 'none'}"


def _environments(record: Record) -> str:
    """Return the mean return of each policy in each environment, the best rule's and more bold."""
    places = in_each_place(record)
    bars = {
        place: max(return_of(block[rule]) for rule in record["rules"])
        for place, block in places.items()
    }

    def cell(policy: str, place: str) -> str:
        mean = return_of(places[place][policy])
        return f"**{mean:.1f}**" if mean >= bars[place] else f"{mean:.1f}"

    policies = ranked(headline(record))
    return markdown_table(
        ("policy", *places),
        [(f"`{policy}`", *(cell(policy, place) for place in places)) for policy in policies],
    )


def _real(record: Record) -> str:
    rows: Rows = []
    for name, what in REAL.items():
        block = record["sets"][name]
        for policy in ranked(block):
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


def real_people(record: Record) -> str:
    """Return which rules have a higher mean return than each learner, among real people."""
    sentences = []
    for name, what in REAL.items():
        block = record["sets"][name]
        best = max(return_of(block[rule]) for rule in record["rules"])
        learned = learned_in(record)
        above = [policy for policy in learned if return_of(block[policy]) > best]
        clear = [policy for policy in learned if block[policy]["return_gain"]["low"] > 0.0]
        worse = [policy for policy in learned if block[policy]["return_gain"]["high"] < 0.0]
        sentences.append(
            f"Among real people {what}, the best rule is {leader(block, record['rules'])}; "
            f"learned policies with a higher mean: {named(above)}. Compared with "
            f"`{record['reference']}`, clearly better are {named(clear)}, clearly worse "
            f"{named(worse)}."
        )
    return " ".join(sentences)


def _exact(record: Record) -> str:
    shares = record["oracle"]
    return markdown_table(
        ("policy", "share, %"),
        [
            (f"`{policy}`", estimate_text(shares[policy], scale=100.0))
            for policy in sorted(shares, key=lambda policy: -shares[policy]["mean"])
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
