"""The page on every algorithm with ten seeds, and README's table, from ``benchmarks/full.json``."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from pathlib import Path
from string import Template

from table_text import estimate_text, markdown_table, verdict

from hazbot_gym.study.default_policies import CONSTANT, family_of
from hazbot_gym.study.headline import scenarios_of
from hazbot_gym.utils.json_object import JsonObject
from hazbot_gym.utils.text_tables import Rows, shown

FULL = Path(__file__).parents[1] / "benchmarks" / "full.json"
Record = JsonObject

FAR = 20.0  # in return: from here a seed crawls, stands or drives too fast
MOST_LEARNERS = 4  # in the README's table
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
    block = _headline(record)
    runs = [run for seeds in record["runs"].values() for run in seeds]
    session = record["sessions"][-1]
    medians = sorted((_seconds(record, learner) for learner in record["runs"]), key=int)
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
        trapped=_trapped(record),
        environments=_environments(record),
        real=_real(record),
        real_ahead=real_people(record),
        exact=_exact(record),
        trials=len(next(iter(search.values()))["trials"]),
        searches=_searches(search),
        tuned="\n".join(f"- `{spec}`" for spec in record["tuned"].values()),
        trainings=len(runs),
        least_s=medians[0],
        most_s=medians[-1],
        core_hours=f"{sum(run['training_seconds'] for run in runs) / 3600:.1f}",
        minutes=f"{session['seconds'] / 60:.0f}",
        prepared=session["prepared"],
        shards=session["shards"],
    )


def readme_table(record: Record) -> str:
    """Return the table for the README: rules and the best learners, real people beside."""
    block = _headline(record)
    learned = [policy for policy in _ranked(block) if policy in _learned(record)]
    shown_policies = {*_best_of_family(record), *learned[:MOST_LEARNERS]}
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
        if policy in shown_policies and family_of(policy) != CONSTANT
    ]
    recorded = scenarios_of(record["sets"][next(iter(REAL))])
    return (
        f"{markdown_table(README_TITLES, rows)}\n\nMeans over {scenarios_of(block)} test "
        f"scenarios in {len(_places(record))} environments, and over {recorded} drives among "
        f"people recorded in corridors and streets, of learners also over {_seeds(record)} "
        "training seeds, from `configs/study_full.yaml`. Of each family of rules the better of "
        f"tuned and default options; [all {len(_learned(record))} learned policies]"
        "(docs/algorithms.md)."
    )


def readme_text(record: Record) -> str:
    """Return what the table says of learners and rules, in the test scenarios and elsewhere."""
    real = "; ".join(
        f"{what} {_leader(block, record['rules'])} and {_leader(block, _learned(record))}"
        for name, what in REAL.items()
        if (block := record["sets"][name])
    )
    return (
        "**In the test scenarios, these policies earn more than the best tuned rule** "
        f"(`{record['best_rule']}`), by the interval of the paired difference: "
        f"{_named(ahead_of_best_rule(record))}. The best rule and the best learned policy among "
        f"real people: {real}."
    )


def _leader(block: Record, policies: Iterable[str]) -> str:
    """Return the policy with the highest mean return in a set, with its return."""
    best = max(policies, key=lambda policy: _return(block[policy]))
    return f"`{best}` ({_return(block[best]):.1f})"


def answer(record: Record, shield: Record) -> str:
    """Return the answer to the paper's question in three sentences, for whoever has a robot.

    Args:
        record: Of ``docs/keep_full.py``.
        shield: Record of the study of contacts, part ``shield`` of ``benchmarks/study.json``.
    """
    block, reference, rule = _headline(record), record["reference"], record["best_rule"]
    best = next(policy for policy in _ranked(block) if policy in _learned(record))
    own, expert = (_means(block[policy]) for policy in (best, reference))
    over_expert, over_rule = block[best]["return_gain"], record["over_best_rule"][best]
    clear = [learner for learner in record["runs"] if block[learner]["return_gain"]["low"] > 0.0]
    ahead = [learner for learner in ahead_of_best_rule(record) if learner in record["runs"]]
    crowd = record["sets"]["real people, seeded"]
    sonar = shield["sets"]["sonar"]["ppo"]["metrics"]["contact_robot_caused"]["mean"]
    return (
        f"1. Where people are tracked, a learned speed policy, `{best}`, {verdict(over_expert)} "
        f"the fuzzy expert ({estimate_text(over_expert)} s): {own['delay_s']:.1f} s of delay a "
        f"drive instead of {expert['delay_s']:.1f} s, {own['person_delay_s']:.1f} s of delay for "
        f"people instead of {expert['person_delay_s']:.1f} s, for {own['personal_m']:.1f} m "
        f"instead of {expert['personal_m']:.1f} m driven within 1.2 m of somebody.\n"
        f"2. It {verdict(over_rule)} the best tuned rule, `{rule}` ({estimate_text(over_rule)} s); "
        f"of {len(record['runs'])} learners with {_seeds(record)} seeds of a minute each, those "
        f"that clearly earn more than the expert are {_named(clear)}, and more than that rule "
        f"{_named(ahead)}.\n"
        f"3. Among recorded people who react, the best rule is {_leader(crowd, record['rules'])}, "
        f"the best learned policy {_leader(crowd, _learned(record))}, and with four sonars alone "
        f"the shipped policy causes a contact in {100 * sonar:.1f} % of the drives: track people, "
        "or use other sensors, before it drives among them."
    )


def ahead_of_best_rule(record: Record) -> list[str]:
    """Return the learned policies with an interval above 0 over the best rule, best first."""
    gains, block = record["over_best_rule"], _headline(record)
    return [
        policy
        for policy in _ranked(block)
        if policy in _learned(record) and gains[policy]["low"] > 0.0
    ]


def _table(record: Record) -> str:
    block, gains = _headline(record), record["over_best_rule"]
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
    block, runs = _headline(record), record["runs"]
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
            for learner in _ranked({name: block[name] for name in runs})
            if (returns := [run["return"] for run in runs[learner]])
        ],
    )


def _trapped(record: Record) -> str:
    """Return how many seeds of which learners end far below the expert."""
    expert = _return(_headline(record)[record["reference"]])
    counts = {
        learner: sum(run["return"] < expert - FAR for run in runs)
        for learner, runs in record["runs"].items()
    }
    found = ", ".join(f"`{learner}` {count}" for learner, count in counts.items() if count)
    return f"more than {FAR:g} below the expert: {found or 'none'}"


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

    policies = _ranked(_headline(record))
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


def real_people(record: Record) -> str:
    """Return which rules have a higher mean return than each learner, among real people."""
    sentences = []
    for name, what in REAL.items():
        block = record["sets"][name]
        best = max(_return(block[rule]) for rule in record["rules"])
        learned = _learned(record)
        above = [policy for policy in learned if _return(block[policy]) > best]
        clear = [policy for policy in learned if block[policy]["return_gain"]["low"] > 0.0]
        worse = [policy for policy in learned if block[policy]["return_gain"]["high"] < 0.0]
        sentences.append(
            f"Among real people {what}, the best rule is {_leader(block, record['rules'])}; "
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


def _learned(record: Record) -> list[str]:
    block = _headline(record)
    return [policy for policy in block if policy not in record["rules"]]


def _best_of_family(record: Record) -> list[str]:
    """Return the rule with the highest mean return of each family, and the reference."""
    block, best = _headline(record), dict[str, str]()
    for rule in reversed(_ranked({rule: block[rule] for rule in record["rules"]})):
        best[family_of(rule)] = rule
    return [record["reference"], *best.values()]


def _headline(record: Record) -> Record:
    return record["sets"][record["headline"]]  # type: ignore[no-any-return]


def _means(found: Record) -> dict[str, float]:
    return {name: estimate["mean"] for name, estimate in found["metrics"].items()}


def _places(record: Record) -> Record:
    """Return the test scenarios of each environment, by its name."""
    first = f"{record['headline']}/"
    sets = record["sets"]
    return {name.removeprefix(first): sets[name] for name in sets if name.startswith(first)}


def _ranked(block: Record) -> list[str]:
    """Return the policies of a set, the highest mean return first."""
    return sorted(block, key=lambda policy: -_return(block[policy]))


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
