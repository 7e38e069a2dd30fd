"""Block diagrams: boxes joined by arrows, for the paper's Figures 8b and 9."""

from __future__ import annotations

from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from hazbot_gym.core.fuzzy_pid import FuzzyPid, rule_tables
from hazbot_gym.core.pid import PidGains
from hazbot_gym.paper.plot_style import BLUE, INK, SOFT, new, svg


class Box(NamedTuple):
    """A box of a diagram: its centre and size on a grid, its text, and the code that does it."""

    x: float
    y: float
    text: str
    code: str = ""
    width: float = 2.2
    height: float = 1.0


class Arrow(NamedTuple):
    """An arrow along some corners, and what runs along it."""

    points: tuple[tuple[float, float], ...]
    text: str = ""
    text_at: tuple[float, float] | None = None


def diagram(boxes: list[Box], arrows: list[Arrow], *, width: float, height: float) -> str:
    """Draw a diagram on a grid of some width and height."""
    figure, axis = new(7.2 * height / width)
    axis.set(xlim=(0.0, width), ylim=(0.0, height), aspect="equal")
    axis.axis("off")
    for arrow in arrows:
        _draw_arrow(axis, arrow)
    for box in boxes:
        _draw_box(axis, box)
    return svg(figure)


def _draw_box(axis: Axes, box: Box) -> None:
    corner = (box.x - 0.5 * box.width, box.y - 0.5 * box.height)
    axis.add_patch(
        Rectangle(corner, box.width, box.height, facecolor="#ffffff", edgecolor=INK, zorder=2)
    )
    lift = 0.14 if box.code else 0.0
    style: Any = {"ha": "center", "va": "center", "zorder": 3}
    axis.text(box.x, box.y + lift, box.text, fontsize=7.5, color=INK, **style)
    if box.code:
        low = box.y - 0.5 * box.height + 0.16
        axis.text(box.x, low, box.code, fontsize=6.0, color=BLUE, family="monospace", **style)


def _draw_arrow(axis: Axes, arrow: Arrow) -> None:
    *before, last = arrow.points
    xs, ys = zip(*arrow.points, strict=True)
    axis.plot(xs[:-1], ys[:-1], color=SOFT, linewidth=1.0, zorder=1)
    axis.annotate(
        "",
        xy=last,
        xytext=before[-1],
        arrowprops={"arrowstyle": "-|>", "color": SOFT, "linewidth": 1.0, "shrinkA": 0.0,
                    "shrinkB": 0.0},
        zorder=1,
    )  # fmt: skip
    if arrow.text:
        x, y = arrow.text_at or (0.5 * (xs[0] + xs[1]), 0.5 * (ys[0] + ys[1]) + 0.16)
        axis.text(x, y, arrow.text, fontsize=7.0, color=INK, ha="center", va="center")


def wheel_loop() -> str:
    """Draw the fuzzy-PID of one wheel (Figure 8b)."""
    base, fuzzy, rules = PidGains(), FuzzyPid(), rule_tables()[0].size
    boxes = [
        Box(0.95, 1.2, "desired wheel\nspeed (eq 13)", width=1.5),
        Box(3.9, 3.0, f"E = s {fuzzy.error_scale:g} e\nEC = s {fuzzy.rate_scale:g} de/dt",
            "FuzzyPid"),
        Box(6.9, 3.0, f"{rules} rules, centroid\nFp, Fi, Fd", "fuzzy_pid.infer", width=2.5),
        Box(10.2, 3.0, f"kp = {base.kp:g} + {fuzzy.kp_span:g} Fp, ki = {base.ki:g} + "
            f"{fuzzy.ki_span:g} Fi,\nkd = {base.kd:g} + {fuzzy.kd_span:g} Fd (eq 15)",
            "fuzzy_pid_gains", width=3.6),
        Box(6.9, 1.2, "u = kp e + ki int e + kd de/dt\n(eq 14)", "pid.pid_law", width=3.4),
        Box(10.6, 1.2, "motor: lag T,\ngain K (1 ± a)", "pid.motor_step", width=2.3),
    ]  # fmt: skip
    arrows = [
        Arrow(((1.7, 1.2), (2.5, 1.2))),
        Arrow(((2.75, 1.2), (5.2, 1.2)), "e, de/dt", (4.5, 1.38)),
        Arrow(((3.9, 1.2), (3.9, 2.5))),
        Arrow(((5.0, 3.0), (5.65, 3.0))),
        Arrow(((8.15, 3.0), (8.4, 3.0))),
        Arrow(((10.2, 2.5), (10.2, 2.1), (6.9, 2.1), (6.9, 1.7)), "gains", (8.6, 2.26)),
        Arrow(((8.6, 1.2), (9.45, 1.2)), "u", (9.0, 1.38)),
        Arrow(((11.75, 1.2), (12.6, 1.2)), "w", (12.2, 1.38)),
        Arrow(((12.2, 1.2), (12.2, 0.3), (2.62, 0.3), (2.62, 1.06)), "measured", (7.0, 0.46)),
        Arrow(((2.62, 1.2), (2.75, 1.2))),
    ]
    return diagram(
        [*boxes, Box(2.62, 1.2, "-", width=0.28, height=0.28)], arrows, width=12.8, height=3.8
    )


def combined() -> str:
    """Draw the combined controller (Figure 9)."""
    boxes = [
        Box(1.3, 2.9, "path: target pose\nand its speed v_r", "geometry.path_pose", width=2.4),
        Box(4.5, 2.9, "pose error\n(eq 10)", "tracking.pose_error", width=2.3),
        Box(7.5, 2.9, "auxiliary controller\n(eq 12c)", "tracking.tracking_law", width=2.5),
        Box(10.7, 2.9, "wheel speeds (eq 13),\ntwo fuzzy-PID loops", "lanes.drive_step", width=2.7),
        Box(13.6, 2.9, "robot\n(eqs 1-3)", "kinematics.arc_step", width=2.2),
        Box(4.5, 0.9, "sensors: distance,\nspeed, pattern", "perception.perceive", width=2.6),
        Box(8.4, 0.9, "fuzzy speed controller\n(eq 9, Table 1)", "FuzzyExpert", width=2.8),
    ]
    arrows = [
        Arrow(((2.5, 2.9), (3.35, 2.9))),
        Arrow(((5.65, 2.9), (6.25, 2.9))),
        Arrow(((8.75, 2.9), (9.35, 2.9)), "v, w", (9.05, 3.08)),
        Arrow(((12.05, 2.9), (12.5, 2.9))),
        Arrow(((13.6, 3.4), (13.6, 3.85), (4.5, 3.85), (4.5, 3.4)), "pose", (9.0, 4.0)),
        Arrow(((13.6, 2.4), (13.6, 0.15), (4.5, 0.15), (4.5, 0.4)), "robot among people",
              (9.0, -0.02)),
        Arrow(((5.8, 0.9), (7.0, 0.9))),
        Arrow(((8.4, 1.4), (8.4, 1.95), (1.3, 1.95), (1.3, 2.4)), "v_r = kept share x 0.5 m/s",
              (5.2, 2.11)),
    ]  # fmt: skip
    return diagram(boxes, arrows, width=15.0, height=4.2)
