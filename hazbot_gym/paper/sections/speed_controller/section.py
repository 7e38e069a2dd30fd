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
                "Terms of distance (a), of the human's speed (b), of the pattern (c) and of the "
                "speed kept (d); dotted: the Gaussian options. Grey: the robot stands up to 1.5 m "
                "and does not react beyond 3.0 m.",
                plots.memberships(),
            ),
            Picture(
                "speed-surfaces",
                "",
                "The share of its speed that the robot keeps, over the distance and the human's "
                "speed, for each pattern.",
                plots.surfaces(),
            ),
            Picture(
                "speed-over-distance",
                "",
                "The same over the distance for a human at 0.5 m/s, by pattern (left); and what "
                "equation 8b changes (right): the robot acts earlier by its speed times t.",
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
        "The inputs are distance, the human's speed and the pattern; the output is the share of "
        "the nominal speed that is kept. Table 1 prints 8 of the 32 combinations of terms. The "
        "other 24 are filled in so that DS stops for every pattern, DF never slows, and the speed "
        "kept never grows with a smaller distance or a faster human; the printed 8 are among them "
        f"unchanged. At 2.25 m from somebody encountering at 0.5 m/s, {kept:.3f} is kept.",
        "The text leaves much open, and most of it matters. Every reading in `experiment.py` was "
        "run in the paper's two scenarios; it is unsafe if the robot moves for more than "
        f"{experiment.LONG_S:g} s while the human is within {SENSITIVE_M:g} m, or into the human, "
        "and degenerate if it never recovers, never stops for somebody who comes to 0.8 m, or is "
        f"slow for more than {experiment.ASTRAY_S:g} s while the human is beyond "
        f"{AVOIDANCE_M:g} m. "
        f"{len(bad)} of {len(verdicts)} are one or the other, or so for a shorter time: "
        f"{'; '.join(bad)}.",
        "The 8 printed rules alone: for somebody who comes straight at it the robot keeps "
        f"{literal.slowest_mps:.2f} m/s and "
        f"{'drives into the human' if literal.hits else 'passes'}; with the 32 rules it stands "
        f"after {complete.stops_s:.1f} s. Taken literally as what is taken away, the percentages "
        "stop the robot far from people and let it go near them. The recursive reading, in which "
        "v(t) is the present speed, stops and never starts again.",
        "Rows that differ from an earlier prototype do so for three reasons. Its "
        "human carried the pattern from the start, whereas here it is recognised within "
        f"{SOCIAL_M:g} m: without the limit at 3.0 m its robot slowed at 0.6 s, because far away "
        "the tail of DS, the widest set, outlasts the others; here it decelerates at "
        f"{no_gate.decelerates_s:.1f} s, and equation 8b with the elapsed time begins later in C*. "
        "Its speed jumped, whereas the drive here brakes and speeds up within limits even where it "
        "is ideal. And its people had no bodies: where the percentages are taken away it passed "
        f"at 0.48 m between centres, here the two touch at {RADII_M:g} m. With a pattern known "
        "from the start and a speed that jumps, the same readings give the prototype's times. The "
        "robot with four ultrasonic sensors moves less near people than the prototype's, because "
        "here it carries on for a while whoever leaves a cone.",
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
        "Readings compared: times [s], least distance [m], seconds of moving within 1.5 m",
        head,
        rows,
    )


def _cells(events: Events) -> tuple[str, ...]:
    times = (events.decelerates_s, events.stops_s)
    shown = [f"{value:.1f}" if not math.isnan(value) else "never" for value in times]
    recovers = "hit" if events.hits else f"{events.recovers_s:.1f}"
    recovers = "never" if recovers == "nan" else recovers
    return (*shown, f"{events.least_m:.2f}", recovers, f"{events.moving_inside_s:.1f}")
