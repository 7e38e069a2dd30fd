"""Figures of pages, drawn at build time from the committed records."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from sphinx.application import Sphinx
from study_report import LEARNED

from hazbot_gym.utils.files import read_json

FOLDER = "_results"
RECORDS = Path(__file__).parents[2] / "benchmarks"
INKS = {"light": "#22282e", "dark": "#d3d8dc"}
STYLES = (  # marks and hues of the report's palette, in a light and a dark shade
    ("o", ("#0067a5", "#5fb2e6")),
    ("D", ("#b83a00", "#ff8a4c")),
    ("^", ("#8a3c8f", "#d58fda")),
    ("s", ("#00785a", "#4cc7a4")),
)
AXES = {"delay_s": "delay, s", "discomfort_s": "discomfort, s"}
WHERE = {"front": "in front of the person", "side": "at the side", "behind": "behind"}
WORLDS = re.compile(r"batched, (\d+) worlds, (\d+) people$")


def _axes(title_x: str, title_y: str, height_in: float = 4.2) -> tuple[Figure, Any]:
    figure = Figure(figsize=(7.2, height_in), layout="constrained")
    axes = figure.subplots()
    axes.set_xlabel(title_x)
    axes.set_ylabel(title_y)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25)
    return figure, axes


def shipped(study: dict[str, Any], shade: int) -> Figure:
    """Draw delay against discomfort of learned policies and rules, with their intervals."""
    title_x, title_y = (f"{title} (less is better)" for title in AXES.values())
    figure, axes = _axes(title_x, title_y)
    for policy, found in study["sets"]["test"].items():
        mark, hues = STYLES[policy == LEARNED]
        x, y = (found["metrics"][name] for name in AXES)
        axes.errorbar(
            x["mean"], y["mean"], fmt=mark, color=hues[shade], elinewidth=1,
            xerr=[[x["mean"] - x["low"]], [x["high"] - x["mean"]]],
            yerr=[[y["mean"] - y["low"]], [y["high"] - y["mean"]]],
        )  # fmt: skip
        axes.annotate(
            policy, (x["mean"], y["mean"]), fontsize=8, xytext=(6, 5), textcoords="offset points"
        )
    axes.margins(x=0.15)
    return figure


def rates(bench: dict[str, Any], shade: int) -> Figure:
    """Draw the steps a second of the batched engine by the number of worlds."""
    figure, axes = _axes("worlds", "steps per second, all worlds together")
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    lines: dict[int, list[tuple[int, float]]] = {}
    for name, case in bench["cases"].items():
        if found := WORLDS.match(name):
            lines.setdefault(int(found[2]), []).append((int(found[1]), case["steps_per_s"]))
    for (mark, hues), (people, points) in zip(STYLES, sorted(lines.items()), strict=False):
        x, y = zip(*sorted(points), strict=True)
        axes.plot(x, y, f"{mark}-", color=hues[shade], label=f"{people} people")
    axes.axhline(bench["CartPole-v1"]["steps_per_s"], ls="--", color="#8a9299", label="CartPole-v1")
    axes.set_xticks(x, [f"{worlds:,}" for worlds in x])
    axes.legend(frameon=False)
    return figure


def discomfort(record: dict[str, Any], shade: int) -> Figure:
    """Draw rated discomfort by distance and direction, with the fitted curves."""
    figure, axes = _axes("distance between centers of robot and nearest person, m", "discomfort")
    x = [row["distance_m"] for row in record["grid"]]
    bins = [row for row in record["bins"] if row["low_m"] is not None]
    floor = record["curve"]["floor"]
    for (mark, hues), direction in zip(STYLES, WHERE, strict=False):
        color = hues[shade]
        values, low, high = (
            [floor + (1.0 - floor) * each for each in line]
            for line in zip(
                *((row[direction]["value"], *row[direction]["interval"]) for row in record["grid"]),
                strict=True,
            )
        )
        axes.plot(x, values, color=color, label=f"robot {WHERE[direction]}")
        axes.fill_between(x, low, high, color=color, alpha=0.15, lw=0)
        middle = [(row["low_m"] + row["high_m"]) / 2 for row in bins]
        axes.plot(middle, [row[direction] for row in bins], mark, color=color, markersize=5)
    axes.legend(frameon=False)
    return figure


def encounters(record: dict[str, Any], shade: int) -> Figure:
    """Draw the closest distance of recorded and model people in encounters that were held out."""
    figure, axes = _axes("closest distance between centers, p10 to p90 and median, m", "")
    groups = [row for row in record["groups"] if not row["fitted_on"]]
    sides = {"recorded": "recorded", "model": "fitted model", "published": "published constants"}
    for place, ((mark, hues), (side, label)) in enumerate(zip(STYLES, sides.items(), strict=False)):
        y = [k + 0.24 * (place - 1) for k in range(len(groups))]
        low, middle, high = zip(*(row[side][:3] for row in groups), strict=True)
        color = hues[shade]
        axes.hlines(y, low, high, color=color, lw=2)
        axes.plot(middle, y, mark, color=color, markersize=5, label=label)
    names = [f"{row['scenario'].replace('_', ' ')}, {row['robot']}" for row in groups]
    axes.set_yticks(range(len(groups)), names)
    axes.invert_yaxis()
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, -0.15), ncols=3)
    return figure


FIGURES = {
    "shipped": (shipped, "study", "shipped"),
    "rates": (rates, "bench", ""),
    "encounters": (encounters, "encounters", ""),
    "discomfort": (discomfort, "discomfort", ""),
}


def write(app: Sphinx) -> None:
    """Write all figures in two shades."""
    if app.builder.format != "html":
        return
    folder = Path(app.outdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for shade, (name, ink) in enumerate(INKS.items()):
        inked = ("axes.label", "axes.edge", "xtick.", "ytick.", "text.")
        style: dict[Any, Any] = {f"{what}color": ink for what in inked}
        with mpl.rc_context({**style, "svg.hashsalt": "0", "font.size": 10}):
            for figure, (draw, source, part) in FIGURES.items():
                record = read_json(RECORDS / f"{source}.json")
                drawn = draw(record[part] if part else record, shade)
                drawn.savefig(
                    folder / f"{figure}-{name}.svg", transparent=True, metadata={"Date": None}
                )


def html(figure: str, text: str) -> str:
    """Return the HTML of a figure that follows the page's theme."""
    pictures = (
        f'<img class="only-{name} figure" src="{FOLDER}/{figure}-{name}.svg" alt="{text}">'
        for name in INKS
    )
    return "".join(pictures)


def setup(app: Sphinx) -> dict[str, Any]:
    """Draw when a build begins."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
