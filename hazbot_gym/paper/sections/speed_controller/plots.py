"""Figures of section 3.2.3: memberships (Figure 6), and the speed controller's output."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.fuzzy import gauss, kept_fraction, two_sided_gauss
from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.paper.plot_style import BLUE, HUES, RED, SOFT, legend, new, rounded, svg
from hazbot_gym.policies.fuzzy_expert import (
    AVOIDANCE_M,
    DISTANCE_TERMS,
    KEPT_TERMS,
    KEPT_WIDTH,
    PATTERN_TERMS,
    PATTERN_WIDTH,
    SENSITIVE_M,
    SPEED_TERMS,
    FuzzyExpert,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def memberships() -> str:
    """Draw the terms of all inputs and of the output (Figures 6a to d)."""
    figure, ((a, b), (c, d)) = new(4.4, 2, 2)
    for axis, terms, unit, ends in (
        (a, DISTANCE_TERMS, "distance R_r [m]", (1.0, 3.4)),
        (b, SPEED_TERMS, "speed of the human V_j [m/s]", (0.0, 2.0)),
    ):
        x = np.linspace(*ends, 181)
        for (name, term), color in zip(terms.items(), HUES, strict=False):
            axis.plot(x, rounded([two_sided_gauss(float(v), *term) for v in x]), color=color)
            _name(axis, name, float(np.clip(term[0], ends[0] + 0.1, ends[1] - 0.1)), color)
        axis.set_xlabel(unit)
    a.axvspan(1.0, SENSITIVE_M, color=SOFT, alpha=0.15)
    a.axvspan(AVOIDANCE_M, 3.4, color=SOFT, alpha=0.15)
    x = np.linspace(-0.5, 3.5, 161)
    for code, (name, color) in enumerate(zip(PATTERN_TERMS, HUES, strict=False)):
        c.plot([code, code], [0.0, 1.0], color=color)
        c.plot(x, rounded([gauss(float(v), code, PATTERN_WIDTH) for v in x]), color=color,
               linewidth=0.9, linestyle=":")  # fmt: skip
        _name(c, name, code, color)
    c.set_xlabel("pattern B_j [code]")
    x = np.linspace(0.0, 1.0, 201)
    for (name, kept), color in zip(KEPT_TERMS.items(), HUES, strict=False):
        d.plot([kept, kept], [0.0, 1.0], color=color)
        d.plot(x, rounded([gauss(float(v), kept, KEPT_WIDTH) for v in x]), color=color,
               linewidth=0.9, linestyle=":")  # fmt: skip
        _name(d, name, kept, color)
    d.set_xlabel("share of speed kept, 1 - dV [-]")
    for axis, label in zip((a, b, c, d), "abcd", strict=True):
        axis.set(ylim=(0.0, 1.25), ylabel="membership [-]", title=f"({label})")
    return svg(figure)


def _name(axis: Axes, name: str, x: float, color: str) -> None:
    axis.text(x, 1.06, name, ha="center", color=color, fontsize=8)


def surfaces() -> str:
    """Draw the speed factor over distance and the human's speed, for each pattern."""
    figure, axes = new(2.5, 1, 4, sharey=True)
    controller = FuzzyExpert().controller
    distance, speed = np.linspace(1.4, 3.1, 69), np.linspace(0.0, 2.0, 41)
    for code, axis in enumerate(axes):
        kept = [
            [kept_fraction(float(r), float(v), code, controller) for r in distance] for v in speed
        ]
        shown = axis.contourf(distance, speed, kept, np.linspace(0.0, 1.0, 11), cmap="viridis")
        axis.set(title=PATTERN_NAMES[code], xlabel="distance [m]")
    axes[0].set_ylabel("speed of the human [m/s]")
    figure.colorbar(shown, ax=axes, label="share kept [-]", ticks=[0, 0.25, 0.5, 0.75, 1])
    return svg(figure)


def over_distance(horizons_s: tuple[float, ...]) -> str:
    """Draw the speed factor over distance for each pattern, and with eq 8b's horizons."""
    figure, (left, right) = new(2.7, 1, 2, sharey=True)
    distance = np.linspace(1.3, 4.2, 233)
    controller = FuzzyExpert().controller
    looks = ("-", "--", ":", "-")  # three patterns have the same speed factor for a slow human
    for code, (color, look) in enumerate(zip(HUES, looks, strict=False)):
        kept = [kept_fraction(float(r), 0.5, code, controller) for r in distance]
        left.plot(distance, rounded(kept), color=color, linestyle=look, label=PATTERN_NAMES[code])
    for horizon_s, color in zip(horizons_s, (BLUE, RED, SOFT), strict=True):
        kept = [kept_fraction(float(r) - 0.5 * horizon_s, 0.5, 1, controller) for r in distance]
        right.plot(distance, rounded(kept), color=color, label=f"t = {horizon_s:g} s")
    left.set(xlabel="distance [m]", ylabel="share of speed kept [-]", title="human at 0.5 m/s")
    right.set(xlabel="distance [m]", title="encountering, eq 8b, robot at 0.5 m/s")
    legend(left)
    legend(right)
    return svg(figure)
