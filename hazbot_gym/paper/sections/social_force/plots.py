"""Pictures of section 3.2.1: Figure 4, the repulsion over distance, and Hall's zones."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.patches import Circle

from hazbot_gym.core.proxemics import PHASE_BOUNDS_M, PHASE_NAMES
from hazbot_gym.core.social_force import HELBING_MOLNAR_1995, SocialForce
from hazbot_gym.paper.plot_style import (
    BLUE,
    GREEN,
    INK,
    OCHRE,
    PURPLE,
    RED,
    SOFT,
    legend,
    new,
    rounded,
    svg,
)
from hazbot_gym.paper.sections.social_force.experiment import BODY_RADII_M, drawn, repulsion_mps2
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, SENSITIVE_M

NEWTON_PER_M = 100.0  # of the arrows
NAMES = {"acceleration": "F_acc", "interaction": "F_int", "attraction": "F_att", "total": "F_total"}
COLORS = {"acceleration": GREEN, "interaction": RED, "attraction": PURPLE, "total": INK}


def situation() -> str:
    """Draw the forces on robot and human (Figure 4)."""
    figure, axis = new(2.8)
    for who, (body, forces) in drawn().items():
        color = BLUE if who == "robot" else OCHRE
        axis.add_patch(
            Circle((body.x, body.y), BODY_RADII_M[who], fill=False, color=color, linewidth=1.4)
        )
        beside = body.x + BODY_RADII_M[who] + 0.08
        axis.text(beside, body.y, who, va="center", color=color, fontsize=8)
        for lane, name in enumerate(NAMES):
            fx, fy = forces.total if name == "total" else getattr(forces, name)
            if abs(fx) + abs(fy) < 1.0:
                continue
            y = body.y + 0.15 * (1.5 - lane)
            axis.quiver(
                body.x, y, fx / NEWTON_PER_M, fy / NEWTON_PER_M, angles="xy", scale_units="xy",
                scale=1.0, width=0.004, color=COLORS[name], zorder=3,
            )  # fmt: skip
    axis.plot([-1.2, -0.2], [-0.75, -0.75], color=SOFT)
    axis.text(-0.7, -0.7, f"{NEWTON_PER_M:g} N", ha="center", fontsize=8, color=SOFT)
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-1.6, 4.4), ylim=(-0.95, 2.0))
    for name, text in NAMES.items():  # in the order of equation 7
        axis.plot([], [], color=COLORS[name], label=text)
    legend(axis, loc="upper left")
    return svg(figure)


def repulsion() -> str:
    """Draw the repulsion over the clearance: published and calibrated constants."""
    figure, axis = new(2.5)
    clearance = np.linspace(0.02, 2.0, 100)
    for name, constants, color in (
        ("Helbing and Molnar 1995", HELBING_MOLNAR_1995, BLUE),
        ("calibrated on people in corridors", SocialForce(), RED),
    ):
        values = [repulsion_mps2(float(c), constants) for c in clearance]
        axis.plot(clearance, rounded(values), color=color, label=name)
    axis.set(xlabel="clearance between two people [m]", ylabel="repulsion [m/s^2]")
    legend(axis)
    return svg(figure)


def zones() -> str:
    """Draw Hall's phases, and the paper's avoidance range."""
    figure, axis = new(1.9)
    edges = (0.0, *PHASE_BOUNDS_M, 8.4)
    for k, (low, high) in enumerate(itertools.pairwise(edges)):
        axis.barh(0.0, high - low, 0.6, left=low, color=BLUE, alpha=0.75 - 0.09 * k,
                  edgecolor="white")  # fmt: skip
        axis.text(0.5 * (low + high), 0.36, PHASE_NAMES[k], rotation=38, ha="left", va="bottom",
                  rotation_mode="anchor", fontsize=7, color=INK)  # fmt: skip
    axis.barh(-0.65, AVOIDANCE_M - SENSITIVE_M, 0.3, left=SENSITIVE_M, color=RED)
    axis.text(
        AVOIDANCE_M + 0.1,
        -0.65,
        f"the paper's avoidance range, {SENSITIVE_M:g} to {AVOIDANCE_M:g} m",
        va="center",
        fontsize=8,
    )
    axis.set(xlim=(0.0, edges[-1]), ylim=(-0.95, 1.1), yticks=[], xlabel="distance [m]")
    axis.set_xticks(PHASE_BOUNDS_M, [f"{bound:g}" for bound in PHASE_BOUNDS_M], fontsize=7)
    axis.grid(visible=False)
    return svg(figure)
