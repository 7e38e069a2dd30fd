"""Panel below a scene: time, outcome, speed, legend, reward terms.

A strip below has the gas, if any, and room for the reward terms of users.
"""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.envs.canvas import (
    FAINT,
    FLOOR,
    GAS,
    INK,
    NOBODY,
    PEOPLE,
    ROBOT,
    SOFT,
    Canvas,
    Color,
    mixed,
)
from hazbot_gym.envs.frame import Frame
from hazbot_gym.envs.plume import GasFrame
from hazbot_gym.envs.scene import DIAMOND, INTIMATE, PERSONAL

HEIGHT_PX = 128
STRIP_PX = 32  # further height with gas or own terms
EDGE_PX = 20.0  # free at both ends
ROWS_PX = (26.0, 51.0, 76.0, 101.0)  # middle of each row
STRIP_ROW_PX = 132.0
SPEED_BAR_PX = 170.0
LEGEND_PX, LEGEND_COLUMN_PX = 214.0, 132.0
LABEL_PX, TERM_BAR_PX, VALUE_PX = 80.0, 56.0, 44.0  # parts of a column of reward terms
TERM_COLUMN_PX = LABEL_PX + TERM_BAR_PX + VALUE_PX + 14.0
FULL_TERM = 1.0  # weighted term at full scale of its half bar, as at full speed
PAPER: Color = (255, 255, 255)
GAIN, LOSS = PEOPLE[1], PEOPLE[3]
FULL_READING = 2.0  # of the gas sensor, at full length of its bar


def draw_panel(canvas: Canvas, frame: Frame, px_per_m: float) -> None:
    """Draw the panel; ``px_per_m`` is the scale of the scene above it."""
    canvas.fill(PAPER)
    canvas.box(0.0, 0.0, canvas.view.width, 1.0, SOFT)
    _draw_state(canvas, frame)
    _draw_legend(canvas, px_per_m)
    _draw_reward(canvas, frame)
    if frame.gas is not None:
        _draw_gas(canvas, frame.gas)


def height_px(*, has_strip: bool) -> int:
    """Return the height of the panel."""
    return HEIGHT_PX + STRIP_PX * has_strip


def _draw_state(canvas: Canvas, frame: Frame) -> None:
    """Write time and outcome, and show the speed; the notch on the bar is the command."""
    first, second, third, fourth = ROWS_PX
    after = EDGE_PX + canvas.text(f"{frame.time_s:.1f} s", EDGE_PX, first, size=26) + 12.0
    color = GAIN if frame.outcome == "arrived" else LOSS
    canvas.text(frame.outcome.replace("_", " "), after, first, color)
    speed, command = (
        SPEED_BAR_PX * min(max(value / frame.top_speed_mps, 0.0), 1.0)
        for value in (frame.speed_mps, frame.command_mps)
    )
    canvas.box(EDGE_PX, second - 5.0, SPEED_BAR_PX, 10.0, FAINT, radius=5)
    if speed >= 1.0:
        canvas.box(EDGE_PX, second - 5.0, max(speed, 10.0), 10.0, ROBOT, radius=5)
    canvas.box(EDGE_PX + command - 1.5, second - 9.0, 3.0, 18.0, INK, radius=1)
    canvas.text(f"speed {frame.speed_mps:z.2f} m/s", EDGE_PX, third, ROBOT)
    canvas.text(f"command {frame.command_mps:z.2f} m/s", EDGE_PX, fourth)


def _draw_legend(canvas: Canvas, px_per_m: float) -> None:
    """Draw the legend of patterns and Hall's zones, and a scale bar of 1 m."""
    colors = zip(PATTERN_NAMES, PEOPLE, strict=True)
    entries = [
        *colors,
        ("intimate zone", INTIMATE),
        ("personal zone", PERSONAL),
        ("no pattern", NOBODY),
    ]
    for i, (name, color) in enumerate(entries):
        x, y = LEGEND_PX + LEGEND_COLUMN_PX * (i % 2), ROWS_PX[i // 2]
        canvas.dot(x + 6.0, y, 6.0, color)
        canvas.text(name, x + 19.0, y)
    x, y = LEGEND_PX + LEGEND_COLUMN_PX, ROWS_PX[3]
    canvas.box(x, y - 1.0, px_per_m, 2.0, INK)
    for end in (x, x + px_per_m - 2.0):
        canvas.box(end, y - 5.0, 2.0, 10.0, INK)
    canvas.text("1 m", x + px_per_m + 8.0, y)


def _draw_gas(canvas: Canvas, gas: GasFrame) -> None:
    """Show the gas sensor's reading; the notch on the bar is the alarm threshold, 1."""
    smell, y = gas.record["smell"][0], STRIP_ROW_PX
    sounds, share = smell["alarm"] == 1, min(max(smell["reading"] / FULL_READING, 0.0), 1.0)
    canvas.box(EDGE_PX, y - 5.0, SPEED_BAR_PX, 10.0, FAINT, radius=5)
    if share * SPEED_BAR_PX >= 1.0:
        length = max(share * SPEED_BAR_PX, 10.0)
        canvas.box(EDGE_PX, y - 5.0, length, 10.0, LOSS if sounds else GAS, radius=5)
    canvas.box(EDGE_PX + SPEED_BAR_PX / FULL_READING - 1.5, y - 9.0, 3.0, 18.0, INK, radius=1)
    canvas.text(f"gas reading {smell['reading']:z.2f}", LEGEND_PX, y)
    if sounds:
        canvas.text("ALARM", LEGEND_PX + LEGEND_COLUMN_PX, y, LOSS, size=26)
    x = LEGEND_PX + 2.0 * LEGEND_COLUMN_PX
    canvas.dot(x + 6.0, y, 6.0, mixed(GAS, FLOOR, 0.4))
    x += canvas.text("gas", x + 19.0, y) + 36.0
    middle = np.array([x + 6.0 - canvas.view.width / 2.0, canvas.view.height / 2.0 - y])
    for size, color in ((8.0, INK), (5.0, GAS)):
        canvas.polygon(middle + size * DIAMOND, color)  # the panel has one pixel per metre
    canvas.text("leak", x + 19.0, y)


def _draw_reward(canvas: Canvas, frame: Frame) -> None:
    """Draw a bar for each weighted term of the last decision, gains to the right."""
    for i, (name, value) in enumerate(frame.terms.items()):
        right, y = _cell(canvas, i)
        zero = right - VALUE_PX - TERM_BAR_PX / 2.0
        length = min(abs(value) / FULL_TERM, 1.0) * TERM_BAR_PX / 2.0
        canvas.text(name, zero - TERM_BAR_PX / 2.0 - 8.0, y, align=1.0)
        canvas.box(zero - TERM_BAR_PX / 2.0, y - 4.0, TERM_BAR_PX, 8.0, FAINT)
        if value > 0.0:
            canvas.box(zero, y - 4.0, length, 8.0, GAIN)
        else:
            canvas.box(zero - length, y - 4.0, length, 8.0, LOSS)
        canvas.box(zero - 0.5, y - 6.0, 1.0, 12.0, INK)
        canvas.text(_number(value), right, y, INK if abs(value) >= 0.005 else SOFT, align=1.0)
    right, y = _cell(canvas, len(frame.terms))
    width = canvas.text(f"{frame.total_reward:z.1f}", right, y, size=26, align=1.0)
    canvas.text("return so far", right - width - 10.0, y, align=1.0)


def _cell(canvas: Canvas, i: int) -> tuple[float, float]:
    """Return the right end and the middle of a cell of the reward's two columns, and the strip."""
    if i == 2 * len(ROWS_PX):
        return canvas.view.width - EDGE_PX, STRIP_ROW_PX
    columns_left = 1 - i // len(ROWS_PX)
    return canvas.view.width - EDGE_PX - TERM_COLUMN_PX * columns_left, ROWS_PX[i % len(ROWS_PX)]


def _number(value: float) -> str:
    return f"{value:z.2f}" if abs(value) < 10.0 else f"{value:.0f}"
