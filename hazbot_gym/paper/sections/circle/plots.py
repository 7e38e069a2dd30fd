"""Pictures of section 5.2: the circle, and the errors over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.state import Floats
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
from hazbot_gym.paper.sections.circle.experiment import BAND, FIGURE_NAMES, Figures, Lap, Point
from hazbot_gym.paper.sections.circle.variants import LOOPS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ENLARGED = 10.0
SHOWN_S = 34.0  # of the lap in Figure 20
EVERY = 20  # samples between two points of a curve
COLORS = {"fuzzy-PID": BLUE, "PID": RED}


def trajectory(lap: Lap, points: list[Point], radius_m: float) -> str:
    """Draw target and actual trajectory, the error enlarged, and the critical points (Fig. 18)."""
    figure, axis = new(4.4)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axis.plot(
        rounded(radius_m * np.sin(angle), 3),
        rounded(radius_m * (1.0 - np.cos(angle)), 3),
        color=SOFT,
        linewidth=1.0,
        label="target circle",
    )
    x, y = (
        rounded(target + ENLARGED * (actual - target), 3)[::EVERY]
        for target, actual in ((lap.x_r, lap.x), (lap.y_r, lap.y))
    )
    axis.plot(x, y, color=BLUE, label=f"robot, error enlarged {ENLARGED:g} times")
    for number, point in enumerate(points, start=1):
        axis.plot(point.xr, point.yr, "s", color=INK, markersize=5)
        offset = (6, 8) if number != 5 else (-10, 8)
        axis.annotate(str(number), (point.xr, point.yr), xytext=offset, textcoords="offset points")
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-6.0, 6.0))
    legend(axis, loc="center")
    return svg(figure)


def errors(laps: Mapping[str, Lap], paper: Mapping[str, Figures]) -> str:
    """Draw position and angle error over time, with what the paper reports (Figs. 20a, b).

    Args:
        laps: By controller.
        paper: By controller: largest position error, largest angle error, and when each converged.
    """
    figure, axes = new(5.4, 2, 1, sharex=True)
    units = ("position error [m]", "angle error [rad]")
    for k, (axis, unit) in enumerate(zip(axes, units, strict=True)):
        for i, (name, lap) in enumerate(laps.items()):
            error = (lap.position_m, lap.angle_rad)[k]
            color, most, when = COLORS[name], paper[name][k], paper[name][2 + k]
            _curve(axis, lap.time_s, error, color, name)
            axis.axhline(most, color=color, linewidth=0.9, linestyle=(0, (4, 3)))
            is_fuzzy = name == "fuzzy-PID"  # the paper states its errors as bounds
            axis.annotate(
                f"paper: {name} {'less than ' if is_fuzzy else ''}{most:g}",
                (17.8, most),
                xytext=(0, -3 if is_fuzzy else 3),
                textcoords="offset points",
                color=color,
                fontsize=8,
                va="top" if is_fuzzy else "bottom",
                ha="right",
            )
            axis.axvline(when, color=color, linewidth=0.9, linestyle=":")
            axis.text(
                when,
                0.28 - 0.14 * i,
                f" paper: {name} converged {when:g} s",
                color=color,
                fontsize=8,
                transform=axis.get_xaxis_transform(),
            )
        axis.set(ylabel=unit, ylim=(0.0, None), xlim=(0.0, SHOWN_S))
        legend(axis, loc="upper right", bbox_to_anchor=(1.0, 0.95))
    axes[1].set_xlabel("time [s]")
    return svg(figure)


def _curve(axis: Axes, time_s: Floats, error: Floats, color: str, name: str) -> None:
    shown = time_s <= SHOWN_S
    axis.plot(rounded(time_s[shown][::5], 2), rounded(error[shown][::5]), color=color, label=name)


def late_errors(laps: Mapping[str, Lap]) -> str:
    """Draw the same errors on a logarithmic scale, which shows convergence."""
    figure, axes = new(2.7, 1, 2)
    for axis, unit, k in zip(
        axes, ("position error [m]", "angle error [rad]"), (0, 1), strict=True
    ):
        for name, lap in laps.items():
            error = (lap.position_m, lap.angle_rad)[k]
            axis.plot(rounded(lap.time_s[::EVERY], 2), np.maximum(error[::EVERY], 1e-6),
                      color=COLORS[name], label=name)  # fmt: skip
        axis.axhline(BAND, color=INK, linewidth=0.9, linestyle=(0, (4, 3)))
        axis.text(
            1.0,
            BAND * 1.6,
            f"below {BAND:g}: converged",
            fontsize=8,
            ha="right",
            transform=axis.get_yaxis_transform(),
        )
        axis.set(xlabel="time [s]", ylabel=unit, yscale="log", ylim=(1e-6, 0.5))
    legend(axes[1])
    return svg(figure)


def misses(found: Mapping[str, Floats], tolerance: float) -> str:
    """Draw the deviations from the paper's eight figures on some plants.

    Args:
        found: Relative differences by plant, (2, 4) each: fuzzy-PID and PID, four figures.
        tolerance: Of a fit, as a share of the paper's figure.
    """
    figure, axis = new(3.4)
    names = [
        f"{controller}, {what.partition(' [')[0]}" for controller in LOOPS for what in FIGURE_NAMES
    ]
    places = np.arange(len(names))[::-1]
    axis.axvspan(-100.0 * tolerance, 100.0 * tolerance, color=SOFT, alpha=0.15)
    axis.axvline(0.0, color=INK, linewidth=0.9)
    for (plant, values), color, marker in zip(found.items(), HUES, "osD^v", strict=False):
        axis.plot(rounded(100.0 * values.ravel(), 2), places, marker, color=color, label=plant,
                  markersize=5, fillstyle="none")  # fmt: skip
    axis.set_yticks(places, names)
    axis.set_xlabel("difference from the paper [%]")
    figure.legend(frameon=False, fontsize=8, loc="outside upper center", ncols=3)
    return svg(figure)
