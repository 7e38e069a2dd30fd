"""Pictures of sections 4 and 5.1 (sensors, delay) and of Figure 19."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hazbot_gym.core.state import Floats
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
from hazbot_gym.paper.sections.combination.experiment import Combination
from hazbot_gym.paper.sections.control_system.experiment import EXTRA_S, Delayed
from hazbot_gym.paper.sections.sensors.experiment import (
    HEADING_RAD,
    TABLE_2,
    WALL_M,
    WHEEL_MPS,
    Readings,
)
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, SENSITIVE_M
from hazbot_gym.task.places import CIRCLE_RADIUS_M

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def readings(found: Readings, half_widths: tuple[float, float, float]) -> str:
    """Draw simulated readings, and the printed ones of Table 2 among them."""
    figure, axes = new(2.5, 1, 3)
    printed = np.array(TABLE_2).T
    names = ("hub motor [m/s]", 'distance [m], column "Angle"', 'heading [rad], column "Ultra"')
    truths = (WHEEL_MPS, WALL_M, HEADING_RAD)
    for k, axis in enumerate(axes):
        axis.hist(found[k], bins=20, color=BLUE, alpha=0.5, label="simulated")
        axis.axvspan(truths[k] - half_widths[k], truths[k] + half_widths[k], color=SOFT,
                     alpha=0.12, zorder=0)  # fmt: skip
        high = axis.get_ylim()[1]
        axis.plot(printed[k], high * np.linspace(0.85, 0.65, 5), "x", color=RED,
                  label="printed")  # fmt: skip
        axis.set(xlabel=names[k], yticks=[])
        axis.grid(axis="y", visible=False)
    axes[0].set_ylabel("how often")
    legend(axes[0], loc="lower center")
    return svg(figure)


def delays(found: dict[str, Delayed]) -> str:
    """Draw the time of motion within 1.5 m over the command delay."""
    figure, axes = new(2.6, 1, len(found), sharey=True)
    for (scenario, each), axis in zip(found.items(), axes, strict=True):
        axis.plot(each.delay_s, rounded(each.inside_s, 3), "o-", color=BLUE, markersize=3.5)
        is_hit = each.hits > 0.0
        axis.plot(each.delay_s[is_hit], each.inside_s[is_hit], "X", color=RED, markersize=8,
                  label="touches the human")  # fmt: skip
        axis.axhline(each.inside_s[0] + EXTRA_S, color=INK, linewidth=0.9,
                     linestyle=(0, (4, 3)), label="affected above")  # fmt: skip
        axis.set(title=scenario, xlabel="delay of the command [s]")
        legend(axis, loc="upper left")
    axes[0].set_ylabel("moves within 1.5 m for [s]")
    return svg(figure)


def _band(axis: Axes, curves: list[Floats], time_s: Floats) -> None:
    """Shade the range of curves over all noise seeds, up to the shortest."""
    shared = min(len(curve) for curve in (*curves, time_s))
    stacked = np.array([curve[:shared] for curve in curves])
    low, high = rounded(stacked.min(axis=0)), rounded(stacked.max(axis=0))
    axis.fill_between(time_s[:shared], low, high, color=BLUE, alpha=0.25, linewidth=0)


def combination(found: Combination) -> str:
    """Draw Figure 19: the encounter on the circle from above, and time series."""
    figure, (above, speed, distance, error) = new(8.2, 4, 1, height_ratios=(2.2, 1.0, 1.0, 1.0))
    run, alone, events = found.runs[0], found.alone[0], found.found[0]
    angle, r = np.linspace(0.0, 2.0 * np.pi, 200), CIRCLE_RADIUS_M
    above.plot(rounded(r * np.sin(angle), 3), rounded(r * (1.0 - np.cos(angle)), 3), color=SOFT,
               linewidth=0.9)  # fmt: skip
    shown = run.time_s <= 24.0
    above.plot(run.x[shown][::20], run.y[shown][::20], "s", color=BLUE, markersize=5,
               label="robot, every 2 s")  # fmt: skip
    above.plot(run.human_x[shown][::20], run.human_y[shown][::20], "o", color=RED,
               fillstyle="none", label="human, every 2 s")  # fmt: skip
    for time_s, style in ((events.decelerates_s, ":"), (events.stops_s, "-")):
        k = int(np.argmin(np.abs(run.time_s - time_s)))
        above.plot([run.x[k], run.human_x[k]], [run.y[k], run.human_y[k]], color=INK,
                   linewidth=1.0, linestyle=style)  # fmt: skip
        above.annotate(f"{run.distance_m[k]:.2f} m at {time_s:.1f} s",
                       (run.human_x[k], run.human_y[k]), xytext=(8, 0),
                       textcoords="offset points", fontsize=8)  # fmt: skip
    above.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-8.0, 9.5), ylim=(-2.2, 10.0))
    legend(above, loc="upper left")
    _band(speed, [run.speed_mps for run in found.runs], run.time_s)
    _band(error, [run.position_error_m for run in found.runs], run.time_s)
    speed.plot(alone.time_s, rounded(alone.speed_mps, 3), color=SOFT, linestyle="--", label="alone")
    speed.plot(run.time_s, rounded(run.speed_mps, 3), color=BLUE, label="with the human")
    speed.set(ylabel="speed [m/s]", ylim=(-0.05, 0.6))
    legend(speed, loc="lower right")
    near = run.distance_m < 8.0
    distance.plot(run.time_s[near], rounded(run.distance_m[near], 3), color=RED)
    for limit in (AVOIDANCE_M, SENSITIVE_M):
        distance.axhline(limit, color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)))
    distance.set(ylabel="distance [m]", ylim=(0.0, 6.0))
    error.plot(alone.time_s, rounded(alone.position_error_m), color=SOFT, linestyle="--")
    error.plot(run.time_s, rounded(run.position_error_m), color=BLUE)
    error.set(ylabel="position error [m]", xlabel="time [s]", ylim=(0.0, None))
    for axis in (speed, distance, error):
        axis.set_xlim(0.0, 50.0)
    return svg(figure)
