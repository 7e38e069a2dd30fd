"""Section 3.3: the fuzzy-PID, its rules and their sign, and the auxiliary controller."""

from __future__ import annotations

from hazbot_gym.core.fuzzy_pid import LIMIT, TABLES, TERMS, FuzzyPid, rule_tables
from hazbot_gym.core.pid import PidGains
from hazbot_gym.core.tracking import TrackingGains
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.fuzzy_pid import blocks as blocks
from hazbot_gym.paper.sections.fuzzy_pid import plots
from hazbot_gym.paper.sections.fuzzy_pid.experiment import LAWS, Left, left_over


def chapter(quick: bool) -> Chapter:
    """Return the section; it takes no time in either form."""
    base, fuzzy, gains = PidGains(), FuzzyPid(), TrackingGains()
    left = {law: left_over(law) for law in LAWS}
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
        record={"printed_law": {law: each._asdict() for law, each in left.items()}},
        text=_text(left["measured"]),
        tables=(*_rule_tables(), _law_table(left)),
        pictures=_pictures(),
    )


def _text(printed: Left) -> tuple[str, ...]:
    return (
        "Equations 10, 11, and 13 to 15 are implemented as printed; a test checks that equation "
        "11 is the derivative of equation 10. Equation 12 as printed has no position feedback: "
        f"at the end of a lap, a position error of {printed.position_m:.3f} m remains. The "
        "corrected law (12c) keeps the form and the three gains, and replaces the velocity "
        "errors with pose errors. Its error provably converges to zero (Lyapunov), and does so "
        "in the simulation. The other two readings come within 5 mm of an earlier prototype "
        "(0.086 and 0.029 m); how the prototype evaluated the rates within a step is not known.",
        "The paper does not print its 49 rules. The rules used here are those of a textbook "
        "(Liu, Advanced PID Control): three tables of 7 x 7. They raise kp for negative errors "
        "only, so the result depends on the sign convention of the error. With actual minus "
        "desired, the paper's own convention in equation 10, the rules help a start from rest. "
        "With the opposite sign, the fuzzy-PID is worse than the PID to which the paper compares "
        "it. Section 5.2 has the numbers, including those for symmetric tables.",
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


def _law_table(left: dict[str, Left]) -> Table:
    return Table(
        "Errors left at the end of a lap, by reading of equation 12 (plant A)",
        ("law", "position error [m]", "angle error [rad]"),
        [
            (text, f"{left[law].position_m:.3f}", f"{left[law].angle_rad:.3f}")
            for law, text in LAWS.items()
        ],
    )


def _pictures() -> tuple[Picture, ...]:
    return (
        Picture(
            "fuzzy-pid-surfaces",
            "Figure 7",
            "The three outputs of the fuzzy-PID as a function of the error e and its rate ec, "
            "both scaled to [-3, 3]: red raises a gain, blue lowers it. The paper does not print "
            "its rules; these are the textbook's.",
            plots.surfaces(),
        ),
        Picture(
            "fuzzy-pid-loop",
            "Figure 8",
            "The fuzzy-PID of one wheel with the paper's parameters; blue: the corresponding "
            "function in the code.",
            blocks.wheel_loop(),
        ),
        Picture(
            "combined-controller",
            "Figure 9",
            "The combined controller: trajectory tracking (top) and the fuzzy speed controller "
            "(bottom), which sets the speed of the target.",
            blocks.combined(),
        ),
        Picture(
            "sign-trap",
            "",
            "Proportional gain as a function of the control error of a wheel, at a rate of zero. "
            "A start from rest begins at the right end. With the opposite sign, the rules lower "
            "the gain there instead of raising it.",
            plots.sign_trap(),
        ),
    )
