"""The report's plots, as plotly figures that the page draws without a network.

Each plot has one figure per choice of its selector. Traces are named by their policy and carry no
legend: the page has one legend for all plots.
"""

from __future__ import annotations

import base64
import functools
from collections.abc import Mapping
from importlib import resources
from typing import NamedTuple

import numpy as np

from hazbot_gym.core.state import Floats
from hazbot_gym.errors import MissingExtra
from hazbot_gym.evaluation.statistics.pareto import AXES
from hazbot_gym.study.replay_records import Drive, Replay
from hazbot_gym.study.report.style import Style, styles
from hazbot_gym.study.results import Family, FrontPoint, Metrics, SetResults
from hazbot_gym.study.summary import LEVELS
from hazbot_gym.utils.json_object import JsonObject

try:
    import plotly.graph_objects as go
except ImportError as error:
    raise MissingExtra(error.name or "plotly", "study") from error

INK, SOFT, GRID, FRONT = "#1c2127", "#5c6670", "#e4e7ea", "#8b9096"
SHADES = {INK: "#e6e9ec", SOFT: "#a3adb6", GRID: "#343b42", FRONT: "#8b9096"}  # on dark paper
CLEAR = "rgba(0,0,0,0)"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif"
TICKS = [float(f"{digit}e{power}") for power in range(-6, 4) for digit in (1, 2, 5)]
LOGARITHMIC = {"type": "log", "tickvals": TICKS, "ticktext": [f"{tick:g}" for tick in TICKS]}
WIDE = 10.0  # ratio of discomforts above which their axis is logarithmic
MARKED = 8  # points with a mark on a line
EVERY = 5  # instants between two points of a distance plot
MOST = 0.8  # share of episodes that the axis of clearance shows,
ENDS_M = (0.3, 2.0)  # and limits of its end


class Event(NamedTuple):
    """An event reported in the paper."""

    what: str
    time_s: float


# By the name of the scenario (paper, section 5.1).
PAPER_EVENTS = {
    "E*": (Event("decelerates", 1.6), Event("stops", 3.4)),
    "C*": (Event("decelerates", 4.6), Event("stops", 8.6)),
}

Styles = Mapping[str, Style]
Figure = JsonObject  # data and layout, as plain values
Point = dict[str, tuple[float, ...]]  # mean, low and high, each on both axes


@functools.cache
def library() -> str:
    """Return plotly's JavaScript as base64 of gzip: its bundle of basic plots, a quarter of all.

    The file is that of the npm package ``plotly.js-basic-dist-min``, version 4.1.1.
    """
    bundle = resources.files("hazbot_gym.study.report") / "template" / "plotly-basic.min.js.gz"
    return base64.b64encode(bundle.read_bytes()).decode()


def front(block: SetResults, looks: Styles) -> Figure:
    """Plot discomfort over delay with intervals; a line joins swept policies.

    Args:
        block: one set of a study's summary.
        looks: the style of each policy.
    """
    figure = go.Figure()
    points = {policy: _point(block[policy]["metrics"]) for policy in looks}
    known = {policy: point for policy, point in points.items() if point is not None}
    swept = sorted(known[policy]["mean"] for policy in known if looks[policy].is_swept)
    if len(swept) > 1:
        x, y = zip(*swept, strict=True)
        line = {"color": FRONT, "width": 1.5, "dash": "dot"}
        figure.add_scatter(x=x, y=y, mode="lines", line=line, hoverinfo="skip", name="")
    for policy, point in known.items():
        look = looks[policy]
        hollow = "-open" if block[policy]["dominated_by"] else ""
        figure.add_scatter(
            x=point["mean"][:1],
            y=point["mean"][1:],
            error_x=_whisker(point, 0, look),
            error_y=_whisker(point, 1, look),
            name=policy,
            mode="markers+text" if look.is_swept else "markers",
            text=[policy.partition(":")[2] or policy],
            textposition="top left" if [point["mean"]] == swept[-1:] else "top right",
            textfont={"color": SOFT, "size": 12},
            marker={"color": look.color, "symbol": look.mark + hollow, "size": 11},
            hovertemplate="delay %{x:.2f} s<br>discomfort %{y:.3f} s",
        )
    figure.update_xaxes(title="delay [s]")
    discomforts = [point["mean"][1] for point in known.values()]
    is_wide = min(discomforts, default=0.0) > 0.0 and max(discomforts) > WIDE * min(discomforts)
    scale = LOGARITHMIC if is_wide else {"rangemode": "tozero"}
    figure.update_yaxes(title="discomfort [s]", **scale)
    return _finish(figure)


def families(block: dict[str, Family]) -> Figure:
    """Plot every point of each family; a line joins the family's Pareto front.

    Args:
        block: of a study's summary, from ``front_summary``.
    """
    figure = go.Figure()
    for family, look in styles(list(block)).items():
        points = block[family]["points"]
        on_front = [each for each in points if each["on_front"]]
        best = sorted(_mean_of(each) for each in on_front)
        line = {"color": look.color, "dash": look.dash, "width": 2}
        x, y = ([each[axis] for each in best] for axis in (0, 1))
        figure.add_scatter(x=x, y=y, mode="lines", line=line, hoverinfo="skip", name=family)
        figure.add_scatter(
            x=[each["delay_s"]["mean"] for each in points],
            y=[each["discomfort_s"]["mean"] for each in points],
            mode="markers",
            name=family,
            marker={"color": look.color, "symbol": look.mark, "size": 8},
            text=[each["policy"] for each in points],
            hovertemplate="%{text}<br>delay %{x:.2f} s<br>discomfort %{y:.3f} s",
        )
    figure.update_xaxes(title="delay [s]", rangemode="tozero")
    figure.update_yaxes(title="discomfort [s]", **LOGARITHMIC)
    return _finish(figure)


def beside_the_best(replay: Replay, looks: Styles) -> Figure:
    """Plot speed over time for every policy, with the oracle's drive as a band."""
    figure, best = go.Figure(), replay.best
    assert best is not None
    figure.add_scatter(
        x=best.time_s.round(2).tolist(),
        y=best.speed_mps.round(3).tolist(),
        name="oracle",
        mode="lines",
        line={"color": GRID, "width": 1},
        fill="tozeroy",
        fillcolor=GRID,
    )
    for policy, look in looks.items():
        run = replay.runs[policy]
        _line(figure, policy, look, run.time_s, run.speed_mps, 3)
    figure.update_xaxes(title="time [s]", rangemode="tozero")
    figure.update_yaxes(title="speed [m/s]", rangemode="tozero")
    return _finish(figure)


def speeds(runs: Mapping[str, Drive], looks: Styles, events: tuple[Event, ...]) -> Figure:
    """Plot speed over time for every policy, with the paper's events as marked lines."""
    figure = go.Figure()
    for policy, look in looks.items():
        episode = runs[policy]
        _line(figure, policy, look, episode.time_s, episode.speed_mps, 3)
    for i, event in enumerate(events):
        figure.add_vline(event.time_s, line={"color": INK, "width": 1, "dash": "dash"})
        figure.add_annotation(
            x=event.time_s,
            y=1.02 + 0.075 * (len(events) - 1 - i),
            yref="paper",
            yanchor="bottom",
            xanchor="left",
            text=f"paper: {event.what} {event.time_s:.1f} s",
            showarrow=False,
            font={"size": 12, "color": INK},
        )
    last = max((event.time_s for event in events), default=0.0)
    figure.update_xaxes(title="time [s]", range=[0.0, last + 14.0])
    figure.update_yaxes(title="speed [m/s]", rangemode="tozero")
    return _finish(figure, top=64)


def distances(runs: Mapping[str, Drive], looks: Styles) -> Figure:
    """Plot distance over time for every policy in one scenario."""
    figure = go.Figure()
    for policy, look in looks.items():
        driven = runs[policy].distance_m
        kept = np.unique(np.append(np.arange(0, len(driven), EVERY), len(driven) - 1))
        _line(figure, policy, look, runs[policy].time_s[kept], driven[kept], 2)
    figure.update_xaxes(title="time [s]", rangemode="tozero")
    figure.update_yaxes(title="distance driven [m]", rangemode="tozero")
    return _finish(figure)


def clearances(block: SetResults, looks: Styles) -> Figure:
    """Plot the cumulative distribution of minimum clearance over episodes, by policy.

    The axis ends where half of the curves have risen to ``MOST``: all that matters is near 0, while
    episodes without an encounter lie far to the right. Episodes without people count in the
    denominator, so that a curve can end below 1.
    """
    figure, ends = go.Figure(), []
    for policy, look in looks.items():
        found = block[policy]["clearance_quantiles_m"]
        points = [(a, b) for a, b in zip(found, LEVELS, strict=True) if a is not None]
        x, y = (np.array([each[axis] for each in points]) for axis in (0, 1))
        ends.append(next((a for a, b in points if b >= MOST), np.inf))
        _line(figure, policy, look, x, y, 2, shape="hv")
    end = float(np.clip(np.median(ends), *ENDS_M))
    figure.update_xaxes(title="minimum clearance [m]", range=[-0.02, end])
    figure.update_yaxes(title="share of episodes", range=[0.0, 1.02])
    return _finish(figure)


def _point(metrics: Metrics) -> Point | None:
    """Return mean, low and high on both axes, None for an unknown mean."""
    means, lows, highs = [], [], []
    for axis in AXES:
        found = metrics[axis]
        mean, low, high = found["mean"], found["low"], found["high"]
        if mean is None:
            return None
        means.append(mean)
        lows.append(mean if low is None else low)
        highs.append(mean if high is None else high)
    return {"mean": tuple(means), "low": tuple(lows), "high": tuple(highs)}


def _mean_of(point: FrontPoint) -> tuple[float, float]:
    """Return the mean of a point on both axes."""
    delay_s, discomfort_s = point["delay_s"]["mean"], point["discomfort_s"]["mean"]
    if delay_s is None or discomfort_s is None:
        raise ValueError(f"a front with {point['policy']!r}, whose mean is unknown")
    return delay_s, discomfort_s


def _whisker(point: Point, axis: int, look: Style) -> Figure:
    """Return the interval as an error bar, of length 0 if unknown."""
    mean, low, high = (point[end][axis] for end in ("mean", "low", "high"))
    return {
        "array": [high - mean],
        "arrayminus": [mean - low],
        "color": look.color,
        "thickness": 1.2,
        "width": 3,
    }


def _line(
    figure: go.Figure, policy: str, look: Style, x: Floats, y: Floats, digits: int, **line: str
) -> None:
    figure.add_scatter(
        x=np.round(x, 2).tolist(),
        y=np.round(y, digits).tolist(),
        name=policy,
        mode="lines+markers",
        line={"color": look.color, "dash": look.dash, "width": 2, **line},
        marker={"color": look.color, "symbol": look.mark, "size": 8, "maxdisplayed": MARKED},
    )


def _finish(figure: go.Figure, top: int = 16) -> Figure:
    """Give a figure the page's look and return it as plain values."""
    figure.update_layout(
        template="none",
        paper_bgcolor=CLEAR,
        plot_bgcolor=CLEAR,
        showlegend=False,
        hovermode="closest",
        hoverlabel={"namelength": -1},
        margin={"l": 56, "r": 16, "t": top, "b": 52},
        font={"family": FONT, "size": 13, "color": INK},
        autosize=True,
        dragmode="pan",
    )
    axis = {"gridcolor": GRID, "zeroline": False, "linecolor": SOFT, "ticks": "outside"}
    figure.update_xaxes(**axis, tickcolor=SOFT, title_standoff=10)
    figure.update_yaxes(**axis, tickcolor=SOFT, title_standoff=10)
    plain: Figure = figure.to_plotly_json()
    return {"data": list(plain["data"]), "layout": plain["layout"]}
