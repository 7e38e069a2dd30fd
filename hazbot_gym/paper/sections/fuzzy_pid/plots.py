"""Figures of section 3.3: gain surfaces, the sign of the error, and pairwise comparisons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hazbot_gym.core.fuzzy_pid import LIMIT, FuzzyPid, fuzzy_pid_gains, gain_table
from hazbot_gym.core.kinematics import Chassis
from hazbot_gym.core.pid import PidGains
from hazbot_gym.paper.plot_style import (
    BLUE,
    HUES,
    INK,
    RED,
    SOFT,
    legend,
    new,
    rounded,
    svg,
)
from hazbot_gym.paper.sections.circle.experiment import Figures, paper_drive

OUTPUTS = ("k_px", "k_ix", "k_dx")


def surfaces() -> str:
    """Draw the three outputs of the inference over error and rate (Figure 7)."""
    figure, axes = new(2.7, 1, 3)
    table = gain_table()
    ticks = np.linspace(-LIMIT, LIMIT, 61)
    picked = table[::2, ::2]
    for axis, name, k in zip(axes, OUTPUTS, range(3), strict=True):
        levels = np.linspace(-LIMIT, LIMIT, 13)
        shown = axis.contourf(ticks, ticks, picked[:, :, k].T, levels, cmap="RdBu_r")
        axis.set(title=name, xlabel="e [-]", aspect="equal")
    axes[0].set_ylabel("ec [-]")
    figure.colorbar(shown, ax=axes, shrink=0.85, ticks=[-3, -2, -1, 0, 1, 2, 3])
    return svg(figure)


def sign_trap() -> str:
    """Draw kp over the control error for both signs, and with symmetric tables."""
    figure, axis = new(2.7)
    error = np.linspace(-2.6, 2.6, 105)
    base = PidGains()
    for sign, tables, color, name in (
        (-1.0, "textbook", BLUE, "rules see actual minus desired (s = -1, chosen)"),
        (1.0, "textbook", RED, "rules see desired minus actual (s = +1)"),
        (-1.0, "symmetric", SOFT, "tables mirrored from their negative half"),
    ):
        table = gain_table(tables)
        fuzzy = FuzzyPid(sign=sign)
        kp = [fuzzy_pid_gains(float(e), 0.0, base, fuzzy, table).kp for e in error]
        axis.plot(error, rounded(kp, 3), color=color, label=name)
    axis.axhline(base.kp, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
    axis.text(-2.6, base.kp + 0.3, f"the PID's kp = {base.kp:g}", fontsize=8)
    start = paper_drive().nominal_speed_mps / Chassis().r
    axis.axvline(start, color=SOFT, linewidth=0.8, linestyle=":")
    axis.text(start, 1.0, "start from rest ", fontsize=8, ha="right", color=SOFT)
    axis.set(xlabel="control error e of a wheel, desired minus actual [rad/s]", ylabel="kp [-]")
    axis.set_ylim(0.0, 19.5)
    legend(axis, loc="upper left")
    return svg(figure)


def controllers(found: Mapping[str, Mapping[str, Figures]]) -> str:
    """Draw the four figures of each controller on each plant.

    Args:
        found: By plant and controller.
    """
    figure, axes = new(2.9, 1, 4)
    titles = ("largest position\nerror [m]", "largest angle\nerror [rad]",
              "position\nconverged [s]", "angle\nconverged [s]")  # fmt: skip
    names = list(next(iter(found.values())))
    for k, (axis, title) in enumerate(zip(axes, titles, strict=True)):
        for i, name in enumerate(names):
            places = np.arange(len(found)) + 0.2 * (i - 0.5 * (len(names) - 1))
            heights = [by_name[name][k] for by_name in found.values()]
            axis.bar(places, heights, 0.18, color=HUES[i], label=name if k == 0 else None)
        axis.set_xticks(range(len(found)), list(found))
        axis.set_title(title, fontsize=9)
        axis.grid(axis="x", visible=False)
        axis.set_xlabel("plant")
    legend(figure, loc="outside upper center", ncols=len(names))
    return svg(figure)


def wins(rows: Sequence[tuple[str, str, float, float]]) -> str:
    """Draw the share of cases in which one controller beats another.

    Args:
        rows: ours, theirs, share in all four errors, share on average.
    """
    figure, axis = new(0.9 + 0.42 * len(rows))
    places = np.arange(len(rows))[::-1]
    axis.barh(places + 0.17, [row[3] for row in rows], 0.3, color=BLUE, label="on average")
    axis.barh(places - 0.17, [row[2] for row in rows], 0.3, color=RED, label="in all four errors")
    axis.axvline(0.5, color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
    axis.set_yticks(places, [f"{ours} beats {theirs}" for ours, theirs, *_ in rows])
    axis.set(xlim=(0.0, 1.0), xlabel="share of plants and disturbances [-]")
    axis.grid(axis="y", visible=False)
    legend(figure, loc="outside upper center", ncols=2)
    return svg(figure)
