"""Section 3.2.3: the fuzzy speed controller, and its alternative readings."""

from __future__ import annotations

import math

from hazbot_gym.core.fuzzy import kept_fraction
from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.meetings.experiment import Events
from hazbot_gym.paper.sections.speed_controller import experiment, plots
from hazbot_gym.policies.fuzzy_expert import (
    AVOIDANCE_M,
    DISTANCE_TERMS,
    KEPT_TERMS,
    PATTERN_TERMS,
    RULES,
    SENSITIVE_M,
    SPEED_TERMS,
    FuzzyExpert,
)
from hazbot_gym.policies.people_seen import RADII_M

HORIZONS_S = (0.0, 0.5, 1.0)


def chapter(quick: bool) -> Chapter:
    """Run the section; it is the same in either form."""
    found = {reading.name: experiment.run(reading) for reading in experiment.READINGS}
    verdicts = {name: experiment.verdict(each) for name, each in found.items()}
    head_on = experiment.head_on()
    kept = [100.0 * share for share in KEPT_TERMS.values()]
    contained = set(RULES["literal8"]) & set(RULES["complete32"])
    return Chapter(
        number="3.2.3",
        title="Fuzzy Controller Design",
        here={
            "de_percent": round(100.0 * DISTANCE_TERMS["DE"][0] / AVOIDANCE_M, 9),
            "dn_percent": round(100.0 * DISTANCE_TERMS["DN"][0] / AVOIDANCE_M, 9),
            "kept_1": kept[1],
            "kept_2": kept[2],
            "kept_3": kept[3],
            "kept_4": kept[4],
            "printed_rules": len(RULES["literal8"]),
            "printed_rules_contained": len(contained),
        },
        record={
            "readings": {
                name: {scenario: _plain(events) for scenario, events in each.items()}
                | {"verdict": verdicts[name]}
                for name, each in found.items()
            },
            "head_on": {name: _plain(events) for name, events in head_on.items()},
        },
        text=_text(verdicts, head_on, found),
        tables=(_rule_table(), _reading_table(found, verdicts)),
        pictures=(
            Picture(
                "speed-memberships",
                "Figure 6",
                "Terms of the distance (a), the human's speed (b), the pattern (c), and the "
                "speed factor (d); dotted: the Gaussian options. Gray: the robot stands still "
                "within 1.5 m and does not react beyond 3.0 m.",
                plots.memberships(),
            ),
            Picture(
                "speed-surfaces",
                "",
                "Speed factor as a function of the distance and the human's speed, for each "
                "pattern.",
                plots.surfaces(),
            ),
            Picture(
                "speed-over-distance",
                "",
                "Left: speed factor as a function of the distance for a human at 0.5 m/s, by "
                "pattern. Right: effect of equation 8b, with which the robot reacts at a "
                "distance larger by its speed times t.",
                plots.over_distance(HORIZONS_S),
            ),
        ),
    )


def _plain(events: Events) -> dict[str, float | None]:
    return {n: None if math.isnan(v) else v for n, v in events._asdict().items()}


def _text(
    verdicts: dict[str, str], head_on: dict[str, Events], found: dict[str, dict[str, Events]]
) -> tuple[str, ...]:
    bad = [name for name, verdict in verdicts.items() if verdict != "works"]
    literal, complete = head_on.values()
    kept = kept_fraction(2.25, 0.5, 1, FuzzyExpert().controller)
    no_gate = found["no limit and no shoulder at 3.0 m"]["E*"]
    return (
        "The inputs are the distance, the human's speed, and the pattern; the output is the "
        "share of the nominal speed that the robot keeps (the speed factor). Table 1 prints 8 of "
        "the 32 combinations of terms. The other 24 are completed so that DS stops the robot for "
        "every pattern, DF never slows it, and the speed factor never increases with a smaller "
        "distance or a faster human. The 8 printed rules are unchanged. At 2.25 m from an "
        f"encountering human at 0.5 m/s, the speed factor is {kept:.3f}.",
        "The text leaves many choices open, and most of them affect the result. Each reading in "
        "`experiment.py` was run in the paper's two scenarios. A reading is unsafe if the robot "
        f"moves for more than {experiment.LONG_S:g} s while the human is within {SENSITIVE_M:g} "
        "m, or drives into the human. It is degenerate if the robot never recovers, never stops "
        f"for a human who comes within 0.8 m, or is slow for more than {experiment.ASTRAY_S:g} s "
        f"while the human is beyond {AVOIDANCE_M:g} m. {len(bad)} of {len(verdicts)} readings "
        f"have one of these defects, or have it for a shorter time: {'; '.join(bad)}.",
        f"With only the 8 printed rules, the robot keeps {literal.slowest_mps:.2f} m/s toward a "
        f"human on a head-on course and {'drives into the human' if literal.hits else 'passes'}; "
        f"with the 32 rules, it stands still after {complete.stops_s:.1f} s. If the percentages "
        "are read literally as the share removed, the robot stops far from people and drives "
        "near them. With the recursive reading, in which v(t) is the present speed, the robot "
        "stops and never starts again.",
        "Rows that differ from an earlier prototype do so for three reasons. First, the "
        "prototype's human had a pattern from the start, whereas here the pattern is recognized "
        f"within {SOCIAL_M:g} m. Without the limit at 3.0 m, the prototype's robot slowed down at "
        "0.6 s, because far away the tail of DS, the widest set, dominates the others. Here the "
        f"robot decelerates at {no_gate.decelerates_s:.1f} s, and equation 8b with the elapsed "
        "time takes effect later in C*. Second, the prototype's speed changed instantly, whereas "
        "even the ideal drive here has acceleration limits. Third, the prototype's people had no "
        "bodies: where the percentages are removed, its robot passed at 0.48 m between centers, "
        f"whereas here contact occurs at {RADII_M:g} m. With a pattern known from the start and "
        "instantaneous speed changes, the same readings give the prototype's times. The robot "
        "with four ultrasonic sensors moves less near people than the prototype's robot, because "
        "here a human who leaves a sensor cone is still tracked for a while.",
    )


def _rule_table() -> Table:
    printed = set(RULES["literal8"])
    answers = {rule[:3]: rule[3] for rule in RULES["complete32"]}
    rows = []
    for distance in DISTANCE_TERMS:
        for speed in SPEED_TERMS:
            cells = []
            for pattern in PATTERN_TERMS:
                kept = answers[distance, speed, pattern]
                mark = " (printed)" if (distance, speed, pattern, kept) in printed else ""
                cells.append(f"{kept}{mark}")
            rows.append((f"{distance}, {speed}", *cells))
    return Table(
        "Table 1, completed: stop VD, 25 % VZ, 50 % VI, 75 % VR, 100 % VT",
        ("distance, speed", *PATTERN_TERMS),
        rows,
    )


def _reading_table(found: dict[str, dict[str, Events]], verdicts: dict[str, str]) -> Table:
    fields = ("decelerates", "stops", "least", "recovers", "moves")
    head = (
        "reading",
        *(f"{scenario} {field}" for scenario in experiment.SCENARIOS for field in fields),
        "verdict",
    )
    rows = []
    for name, each in found.items():
        values = [value for scenario in experiment.SCENARIOS for value in _cells(each[scenario])]
        rows.append((name, *values, verdicts[name]))
    return Table(
        "Comparison of readings: times [s], minimum distance [m], time moving within 1.5 m [s]",
        head,
        rows,
    )


def _cells(events: Events) -> tuple[str, ...]:
    times = (events.decelerates_s, events.stops_s)
    shown = [f"{value:.1f}" if not math.isnan(value) else "never" for value in times]
    recovers = "hit" if events.hits else f"{events.recovers_s:.1f}"
    recovers = "never" if recovers == "nan" else recovers
    return (*shown, f"{events.least_m:.2f}", recovers, f"{events.moving_inside_s:.1f}")
