"""Pictures of section 5.1: meetings from above, and speed and distance over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hazbot_gym.paper.plot_style import (
    BLUE,
    INK,
    RED,
    SOFT,
    legend,
    mark_event,
    new,
    rounded,
    svg,
)
from hazbot_gym.paper.sections.meetings.experiment import Events, Meeting
from hazbot_gym.policies.fuzzy_expert import AVOIDANCE_M, SENSITIVE_M

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOWN_S = 18.0
MARKED_S = 1.0  # between two markers of a path, as in the paper

PaperEvents = Sequence[tuple[str, float]]  # events reported in the paper


def meeting(
    run: Meeting, found: Events, paper: PaperEvents, *, is_measured: bool = False, others: Any = ()
) -> str:
    """Draw a meeting from above, and below it speed and distance over time.

    Args:
        run: The encounter.
        found: Its events.
        paper: Events that the paper reports.
        is_measured: Whether the robot's own speed is drawn instead of the commanded one.
        others: More meetings whose speed is drawn thin behind.
    """
    figure, (above, speed, distance) = new(6.6, 3, 1, height_ratios=(1.25, 1.0, 1.0))
    _from_above(above, run, found)
    speed.sharex(distance)
    shown = run.time_s <= SHOWN_S
    for other in others:
        _step(speed, other, is_measured, color=SOFT, linewidth=0.5, alpha=0.4)
    _step(speed, run, is_measured, color=BLUE, label=_what(is_measured))
    for i, (what, when) in enumerate(paper):
        mark_event(speed, when, f"paper: {what} {when:g} s", height=0.98 - 0.12 * i)
    _mark_ours(speed, found)
    speed.set(ylabel="speed [m/s]", ylim=(-0.05, 0.66), xlim=(0.0, SHOWN_S))
    legend(speed, loc="lower right")
    distance.plot(rounded(run.time_s[shown], 2), rounded(run.distance_m[shown], 3), color=RED)
    for limit, name in ((AVOIDANCE_M, "avoidance distance"), (SENSITIVE_M, "sensitive distance")):
        distance.axhline(limit, color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)))
        distance.text(0.1, limit, f"{name} {limit:g} m", va="top", fontsize=8, color=SOFT)
    distance.set(xlabel="time [s]", ylabel="distance of centres [m]", ylim=(0.0, None))
    return svg(figure)


def _what(is_measured: bool) -> str:
    return "robot's speed" if is_measured else "commanded speed"


def _step(axis: Axes, run: Meeting, is_measured: bool, **look: Any) -> None:
    shown = run.time_s <= SHOWN_S
    values = run.speed_mps if is_measured else run.command_mps
    draw: Any = axis.plot if is_measured else axis.step
    style = {} if is_measured else {"where": "post"}
    draw(rounded(run.time_s[shown], 2), rounded(values[shown], 3), **style, **look)


def _mark_ours(axis: Axes, found: Events) -> None:
    for time_s, share in ((found.decelerates_s, 0.98), (found.stops_s, 0.05)):
        if np.isfinite(time_s):
            axis.plot(time_s, 0.5 * share, "o", color=BLUE, fillstyle="none")
            axis.annotate(
                f"{time_s:.1f} s", (time_s, 0.5 * share), xytext=(6, 5), ha="left",
                textcoords="offset points", color=BLUE, fontsize=8,
            )  # fmt: skip


def _from_above(axis: Axes, run: Meeting, found: Events) -> None:
    shown = run.time_s <= SHOWN_S
    axis.plot(rounded(run.x[shown], 3), rounded(run.y[shown], 3), color=BLUE, linewidth=0.8)
    axis.plot(rounded(run.human_x[shown], 3), rounded(run.human_y[shown], 3), color=RED,
              linewidth=0.8)  # fmt: skip
    every = round(MARKED_S / float(run.time_s[1] - run.time_s[0]))
    axis.plot(run.x[shown][::every], run.y[shown][::every], "s", color=BLUE, markersize=5,
              label="robot, every second")  # fmt: skip
    axis.plot(run.human_x[shown][::every], run.human_y[shown][::every], "o", color=RED,
              fillstyle="none", markersize=6, label="human, every second")  # fmt: skip
    for time_s, style, at_human in ((found.decelerates_s, ":", True), (found.stops_s, "-", False)):
        if np.isfinite(time_s):
            k = int(np.argmin(np.abs(run.time_s - time_s)))
            robot, human = (run.x[k], run.y[k]), (run.human_x[k], run.human_y[k])
            axis.plot(*zip(robot, human, strict=True), color=INK, linewidth=1.0, linestyle=style)
            axis.annotate(
                f"{run.distance_m[k]:.2f} m at {time_s:.1f} s", human if at_human else robot,
                xytext=(8, 8) if at_human else (-2, -17), textcoords="offset points", fontsize=8,
                ha="left" if at_human else "right",
            )  # fmt: skip
    high = max(1.6, float(run.human_y[0]) + 0.4)
    axis.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", xlim=(-1.0, 8.5), ylim=(-1.1, high))
    legend(axis, loc="upper right")
