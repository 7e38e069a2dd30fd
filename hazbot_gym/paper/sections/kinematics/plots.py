"""Pictures of section 3.1: Figure 3, and the robot on a turn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.kinematics import radius_from_castor, ratio_from_castor
from hazbot_gym.paper.plot_style import (
    BLUE,
    INK,
    RED,
    SOFT,
    legend,
    new,
    rounded,
    svg,
)
from hazbot_gym.paper.sections.kinematics.experiment import (
    CHASSIS,
    PAPER_BETA_RAD,
    PAPER_RADIUS_M,
    PAPER_RATIO,
    Turn,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def turning(turns: list[Turn]) -> str:
    """Draw radius and wheel ratio over the castor angle, with the paper's points and ours."""
    figure, axes = new(2.9, 1, 2)
    beta = np.radians(np.linspace(8.0, 40.0, 200))
    curves = (radius_from_castor, ratio_from_castor)
    labels = ("turning radius R [m]", "wheel ratio w1/w2 [-]")
    for axis, curve, label in zip(axes, curves, labels, strict=True):
        values = rounded([curve(float(b), CHASSIS) for b in beta])
        axis.plot(np.degrees(beta), values, color=BLUE, label="equations 5 and 6")
        axis.set(xlabel="castor angle [deg]", ylabel=label)
    degrees = math.degrees(PAPER_BETA_RAD)
    for axis, paper in zip(axes, (PAPER_RADIUS_M, PAPER_RATIO), strict=True):
        axis.plot(degrees, paper, "x", color=RED, markersize=8, label="paper")
    exact = turns[0]
    beside = ((8, 8), (8, -12))  # where the curve leaves room
    for axis, value, offset in zip(axes, (exact.radius_m, exact.ratio), beside, strict=True):
        axis.plot(degrees, value, "o", color=BLUE, fillstyle="none", label="at 20 deg")
        axis.annotate(
            f"{value:.3f}", (degrees, value), xytext=offset, textcoords="offset points", color=BLUE
        )
    axes[0].set_ylim(0.0, 3.0)
    axes[1].set_ylim(1.0, 2.6)
    legend(axes[0])
    return svg(figure)


def robot(turn: Turn) -> str:
    """Draw the robot from above on its turn: wheels, castor, and where their axles meet."""
    figure, axis = new(3.6)
    half, pivot_m = 0.5 * CHASSIS.L, -(CHASSIS.L1 + CHASSIS.L2)
    _wheel(axis, 0.0, half, 0.0, INK)
    _wheel(axis, 0.0, -half, 0.0, INK)
    beta = turn.beta_rad
    # In a left turn the castor's wheel trails outward: its axle then points at the centre.
    x, y = pivot_m - CHASSIS.L3 * math.cos(beta), -CHASSIS.L3 * math.sin(beta)
    _wheel(axis, x, y, beta, RED)
    axis.plot([pivot_m, x], [0.0, y], color=RED, linewidth=2.0)
    axis.plot([0.0, 0.0], [-half, turn.radius_m], color=SOFT, linewidth=0.9, linestyle="--")
    axis.plot([x, 0.0], [y, turn.radius_m], color=SOFT, linewidth=0.9, linestyle="--")
    axis.plot([pivot_m, 0.0], [0.0, 0.0], color=INK, linewidth=0.9)
    axis.plot(0.0, turn.radius_m, "o", color=BLUE)
    axis.annotate("center of the turn", (0.0, turn.radius_m), xytext=(0.04, turn.radius_m - 0.02))
    axis.annotate("M", (0.0, 0.0), xytext=(0.03, 0.03))
    axis.annotate("w2 (left)", (0.0, half), xytext=(0.14, half))
    axis.annotate("w1 (right)", (0.0, -half), xytext=(0.14, -half))
    axis.annotate(
        f"castor, {math.degrees(beta):.0f} deg", (x, y), xytext=(x - 0.42, y - 0.2), color=RED
    )
    axis.annotate(f"R = {turn.radius_m:.3f} m", (0.0, 0.6), xytext=(0.03, 0.62), color=BLUE)
    axis.set(xlabel="x, ahead [m]", ylabel="y, to the left [m]", aspect="equal")
    axis.set_xlim(-1.4, 1.4)
    axis.set_ylim(-0.45, 1.3)
    return svg(figure)


def _wheel(axis: Axes, x: float, y: float, angle_rad: float, color: str) -> None:
    dx, dy = 0.1 * math.cos(angle_rad), 0.1 * math.sin(angle_rad)
    axis.plot([x - dx, x + dx], [y - dy, y + dy], color=color, linewidth=5.0)
