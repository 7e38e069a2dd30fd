"""Section 3.3: the fuzzy-PID, its rules and their sign, and whether fuzziness is what helps."""

from __future__ import annotations

from typing import Any

from hazbot_gym.core.fuzzy_pid import LIMIT, TABLES, TERMS, FuzzyPid, rule_tables
from hazbot_gym.core.pid import PLANTS, PidGains
from hazbot_gym.core.tracking import TrackingGains
from hazbot_gym.paper import tuned_pid
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.circle import Figures
from hazbot_gym.paper.figures import blocks
from hazbot_gym.paper.figures import fuzzy_pid as figures
from hazbot_gym.paper.printed_law import LAWS, left_over

PAIRS = (
    ("fuzzy-PID", "PID"),
    ("tuned PID", "PID"),
    ("fuzzy-PID", "tuned PID"),
    ("tuned fuzzy-PID", "tuned PID"),
)
FULL, QUICK = (30, 1), (3, 8)  # generations of the search, every n-th plant of the sweep


def chapter(quick: bool) -> Chapter:
    """Run the section."""
    generations, every = QUICK if quick else FULL
    base, fuzzy, gains = PidGains(), FuzzyPid(), TrackingGains()
    tuned = {
        "tuned PID": tuned_pid.tune(tuned_pid.pid_of, 3, generations=generations, seed=0),
        "tuned fuzzy-PID": tuned_pid.tune(
            tuned_pid.fuzzy_pid_of, 6, generations=generations, seed=0
        ),
    }
    controllers = {
        "PID": tuned_pid.pid(base),
        "fuzzy-PID": tuned_pid.fuzzy_pid(base, fuzzy),
        **{name: each.drive for name, each in tuned.items()},
    }
    plants = {
        plant: {name: tuned_pid.run(drive, plant) for name, drive in controllers.items()}
        for plant in PLANTS
    }
    rows = tuned_pid.sweep(controllers, every=every)
    wins = {pair: tuned_pid.wins(rows, *pair) for pair in PAIRS}
    by_disturbance = {
        name: {
            f"{ours} beats {theirs}": tuned_pid.wins(
                [row for row in rows if row["disturbance"] == name], ours, theirs
            )._asdict()
            for ours, theirs in PAIRS
        }
        for name in tuned_pid.DISTURBANCES
    }
    return Chapter(
        number="3.3",
        title="Combination Autonomous Behavior Strategy",
        here={
            "a1": gains.a1,
            "a2": gains.a2,
            "a3": gains.a3,
            "universe_low": -LIMIT,
            "universe_high": LIMIT,
            "fuzzy_pid_rules": rule_tables()[0].size,
            "k_e": fuzzy.error_scale,
            "k_ec": fuzzy.rate_scale,
            "k_1": fuzzy.kp_span,
            "k_2": fuzzy.ki_span,
            "k_3": fuzzy.kd_span,
            "kp_0": base.kp,
            "ki_0": base.ki,
            "kd_0": base.kd,
        },
        record={
            "printed_law": {law: left_over(law)._asdict() for law in LAWS},
            "tuned": {name: each._asdict() for name, each in tuned.items()},
            "plants": {
                plant: {name: found._asdict() for name, found in by_name.items()}
                for plant, by_name in plants.items()
            },
            "sweep": {
                "cases": len(rows) // len(controllers),
                "lost": {name: tuned_pid.lost(rows, name) for name in controllers},
                "all": {f"{a} beats {b}": found._asdict() for (a, b), found in wins.items()},
                "by_disturbance": by_disturbance,
            },
        },
        text=_text(tuned, wins, rows, controllers, plants),
        tables=(*_rule_tables(), _law_table(), _tuned_table(tuned), _plant_table(plants)),
        pictures=_pictures(plants, wins),
    )


def _text(
    tuned: dict[str, tuned_pid.Tuned],
    wins: dict[tuple[str, str], tuned_pid.Wins],
    rows: list[dict[str, Any]],
    controllers: dict[str, Any],
    plants: dict[str, dict[str, Figures]],
) -> tuple[str, ...]:
    fixed = left_over("measured")
    rule_spans = tuned["tuned fuzzy-PID"].drive["fuzzy"]
    cases = len(rows) // len(controllers)
    paper, to_pid = wins["fuzzy-PID", "PID"], wins["tuned PID", "PID"]
    to_tuned, both = wins["fuzzy-PID", "tuned PID"], wins["tuned fuzzy-PID", "tuned PID"]
    lost = ", ".join(f"{name} {tuned_pid.lost(rows, name)}" for name in controllers)
    return (
        "Equations 10, 11 and 13 to 15 are taken as printed; that 11 is the derivative of 10 is a "
        "test. Equation 12 as printed feeds back no position: at the end of a lap "
        f"{fixed.position_m:.3f} m of position error are left. The corrected law (12c) keeps its "
        "form and its three gains, with the pose errors where the velocity errors stand; its error "
        "can be shown to die out (Lyapunov), and does.",
        "The paper prints none of its 49 rules. Taken here are the textbook's (Liu, Advanced PID "
        "Control), three tables of 7 x 7. They raise kp for negative errors only, so everything "
        "depends on the sign with which they see the error: as actual minus wanted, the paper's "
        "own convention of equation 10, they help a start from rest; the other way round the "
        "fuzzy-PID is worse than the PID that it is compared with.",
        "Is it the fuzziness that helps? The paper's PID was tuned by nobody. With the same search "
        f"of {tuned['tuned PID'].laps} laps each, on plant B, a PID within the gains that the "
        f"paper's fuzzy-PID can reach comes to {tuned['tuned PID'].objective:.2f} of the paper's "
        "PID's figures in the mean, the fuzzy-PID of the paper to "
        f"{tuned_pid.objective(plants['B']['fuzzy-PID'], plants['B']['PID']):.2f}, and a tuned "
        f"fuzzy-PID to {tuned['tuned fuzzy-PID'].objective:.2f}. Tuning turns the rules nearly off "
        f"for kp and ki (k_1 = {rule_spans['kp_span']:.2g} of 3, k_2 = "
        f"{rule_spans['ki_span']:.2g} of 1): what helps is a large kp.",
        f"Over {cases} cases (plants of SPEC section 5 with and without mismatched wheels, under "
        "no disturbance, sensor noise, a load, and saturation) the paper's fuzzy-PID beats its "
        f"PID in all four errors in {paper.in_all:.0%} and on average in {paper.on_average:.0%} of "
        "those in which at least one of the two keeps to the circle. But the tuned PID beats that "
        f"PID in {to_pid.on_average:.0%}, and the fuzzy-PID of the paper beats the tuned PID in "
        f"{to_tuned.on_average:.0%}. A tuned fuzzy-PID is better than a tuned PID on average in "
        f"{both.on_average:.0%}, with a median ratio of errors of {both.median_ratio:.3f}. Cases "
        f"in which the robot is lost by more than {tuned_pid.LOST_M:g} m: {lost}.",
    )


def _rule_tables() -> list[Table]:
    """Return the three tables of rules, and how many cells symmetric ones change."""
    names = ("k_px", "k_ix", "k_dx")
    textbook, symmetric = (rule_tables(tables) for tables in TABLES)
    return [
        Table(
            f"Rules of {name}: rows e, columns ec; with symmetric tables "
            f"{int((textbook[k] != symmetric[k]).sum())} of 49 cells differ",
            ("e \\ ec", *TERMS),
            [(TERMS[i], *(TERMS[code + 3] for code in textbook[k][i])) for i in range(7)],
        )
        for k, name in enumerate(names)
    ]


def _law_table() -> Table:
    return Table(
        "What is left at the end of a lap, by reading of equation 12 (plant A)",
        ("law", "position error [m]", "angle error [rad]"),
        [
            (text, f"{left_over(law).position_m:.3f}", f"{left_over(law).angle_rad:.3f}")
            for law, text in LAWS.items()
        ],
    )


def _tuned_table(tuned: dict[str, tuned_pid.Tuned]) -> Table:
    rows = [
        (
            name,
            *(f"{gain:.2f}" for gain in each.drive["pid"].values()),
            *(
                f"{each.drive['fuzzy'][span]:.2f}" if "fuzzy" in each.drive else "-"
                for span in ("kp_span", "ki_span", "kd_span")
            ),
            f"{each.objective:.3f}",
        )
        for name, each in tuned.items()
    ]
    head = ("controller", "kp'", "ki'", "kd'", "k_1", "k_2", "k_3", "mean of four ratios")
    return Table("Tuned on plant B with the same number of laps", head, rows)


def _plant_table(plants: dict[str, dict[str, Figures]]) -> Table:
    return Table(
        "All controllers on all plants; tuned ones were tuned on B",
        (
            "plant, controller",
            "largest position error [m]",
            "largest angle error [rad]",
            "position converged [s]",
            "angle converged [s]",
        ),
        [
            (
                f"{plant}, {name}",
                f"{found.position_max_m:.3f}",
                f"{found.angle_max_rad:.3f}",
                f"{found.position_converged_s:.2f}",
                f"{found.angle_converged_s:.2f}",
            )
            for plant, by_name in plants.items()
            for name, found in by_name.items()
        ],
    )


def _pictures(
    plants: dict[str, dict[str, Figures]], wins: dict[tuple[str, str], tuned_pid.Wins]
) -> tuple[Picture, ...]:
    return (
        Picture(
            "fuzzy-pid-surfaces",
            "Figure 7",
            "The three outputs of the fuzzy-PID over error e and its rate ec, both scaled to "
            "[-3, 3]: red raises a gain, blue lowers it. The paper's rules are not printed; these "
            "are the textbook's.",
            figures.surfaces(),
        ),
        Picture(
            "fuzzy-pid-loop",
            "Figure 8",
            "The fuzzy-PID of one wheel with the paper's parameters; in blue, what does it in the "
            "code.",
            blocks.wheel_loop(),
        ),
        Picture(
            "combined-controller",
            "Figure 9",
            "The combined controller: trajectory tracking above, and below it the fuzzy speed "
            "controller, which sets how fast the target moves on.",
            blocks.combined(),
        ),
        Picture(
            "sign-trap",
            "",
            "The proportional gain over the control error of a wheel, at a rate of zero. A robot "
            "that starts from rest begins at the right end. With the other sign the rules take "
            "away there what they should give.",
            figures.sign_trap(),
        ),
        Picture(
            "tuned-controllers",
            "",
            "The four figures of section 5.2 for each controller on each plant: less is better.",
            figures.controllers(plants),
        ),
        Picture(
            "fuzzy-pid-wins",
            "",
            "In which share of plants and disturbances one controller beats another; a controller "
            "that is lost has lost.",
            figures.wins([(*pair, found.in_all, found.on_average) for pair, found in wins.items()]),
        ),
    )
