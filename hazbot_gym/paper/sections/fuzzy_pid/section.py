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
        "Equations 10, 11 and 13 to 15 are taken as printed; that 11 is the derivative of 10 is a "
        "test. Equation 12 as printed feeds back no position: at the end of a lap "
        f"{printed.position_m:.3f} m of position error are left. The corrected law (12c) keeps its "
        "form and its three gains, with the pose errors where the velocity errors stand; its error "
        "can be shown to die out (Lyapunov), and does. The other two readings come within "
        "5 mm of an earlier prototype (0.086 and 0.029 m); how it took the rates within "
        "a step is not known.",
        "The paper prints none of its 49 rules. Taken here are the textbook's (Liu, Advanced PID "
        "Control), three tables of 7 x 7. They raise kp for negative errors only, so everything "
        "depends on the sign with which they see the error: as actual minus wanted, the paper's "
        "own convention of equation 10, they help a start from rest; the other way round the "
        "fuzzy-PID is worse than the PID that it is compared with. Section 5.2 has the numbers, "
        "also those of tables without that sign.",
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
        "What is left at the end of a lap, by reading of equation 12 (plant A)",
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
            "The three outputs of the fuzzy-PID over error e and its rate ec, both scaled to "
            "[-3, 3]: red raises a gain, blue lowers it. The paper's rules are not printed; these "
            "are the textbook's.",
            plots.surfaces(),
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
            plots.sign_trap(),
        ),
    )
