"""Figure style: deterministic SVG, without a display."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from hazbot_gym.errors import MissingExtra

try:
    import matplotlib as mpl
    from matplotlib.figure import Figure
except ImportError as error:
    raise MissingExtra(error.name or "matplotlib", "study") from error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, SOFT, GRID = "#1c2127", "#5c6670", "#e4e7ea"
BLUE, RED, GREEN, PURPLE, OCHRE = "#0067a5", "#b83a00", "#00785a", "#8a3c8f", "#856200"
HUES = (BLUE, RED, GREEN, PURPLE, OCHRE)
WIDTH_IN = 7.2  # of a figure across the page
SETTINGS: dict[Any, object] = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "hazbot_gym",  # ids that do not change from run to run
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "lines.linewidth": 1.6,
}


def new(
    height_in: float = 3.0, rows: int = 1, columns: int = 1, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure and its axes, as ``Figure.subplots`` returns them."""
    with mpl.rc_context(SETTINGS):
        figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
        return figure, figure.subplots(rows, columns, **options)


def mark_event(axes: Axes, time_s: float, text: str, *, height: float = 1.0) -> None:
    """Mark an event that the paper reports: a dashed line over the whole height, and its name.

    Args:
        axes: Axes with time on the x axis.
        time_s: Time of the event.
        text: Label, such as ``paper: stops, 3.4 s``.
        height: Height of the text, as a share of the axes' height.
    """
    axes.axvline(time_s, color=INK, linewidth=0.9, linestyle=(0, (4, 3)))
    place = axes.get_xaxis_transform()
    axes.text(time_s, height, f" {text}", transform=place, va="top", fontsize=8, color=INK)


def legend(axes: Axes | Figure, **options: Any) -> None:
    """Add a legend without a frame."""
    axes.legend(frameon=False, **{"fontsize": 8, **options})


def svg(figure: Figure) -> str:
    """Return a figure as the text of an ``<svg>`` element."""
    buffer = io.StringIO()
    with mpl.rc_context(SETTINGS):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def rounded(values: object, digits: int = 4) -> Any:
    """Return values rounded to visible digits, for small files."""
    return np.round(np.asarray(values, dtype=np.float64), digits)
