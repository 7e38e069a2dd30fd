"""Scenes for the front page that a reader can drive: the exact engine, in the browser.

The kernels are compiled to WebAssembly, the starts of some episodes are drawn here, and the scripts
of the page of ``hazbot play`` draw. One file holds everything, so that it also works where it is
opened from disk.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

from scene_memory import SceneMemory, Start, shared_memory
from sphinx.application import Sphinx
from sphinx.util import logging

from hazbot_gym.core.state import PRESENT
from hazbot_gym.evaluation.rollout import resolve
from hazbot_gym.export.wasm import FIRST, Kernel, compiled
from hazbot_gym.live import view
from hazbot_gym.live.policies import GAS_ONLY, OFFERED
from hazbot_gym.live.run import Hand, Run
from hazbot_gym.live.settings import YOU, Settings
from hazbot_gym.task.outcome import OUTCOME_NAMES
from hazbot_gym.utils import provenance

FILE = "scenes.html"
HERE = Path(__file__).parent
STATIC = HERE.parents[1] / "hazbot_gym" / "live" / "static"
SCRIPTS = (*(STATIC / name for name in ("shapes.js", "floor.js", "place.js", "motion.js")),
           HERE / "engine.js")  # each after what it imports  # fmt: skip
EPISODES = 5
UNDO_LAG = "undo_lag:people=fuzzy_expert"
SCENES = {
    "The paper's crossing": Settings(env="C*", policy="fuzzy_expert", ghost="ppo"),
    "A doorway": Settings(env="Doorway-v1", policy="fuzzy_expert", ghost="ppo"),
    "An inspection": Settings(env="Inspection-v1", seed=1, policy=UNDO_LAG, ghost="fuzzy_expert"),
}
# Of a scene, what the place draws.
SHOWN = (
    "decision_s", "top_speed_mps", "walls", "path", "box", "zones_m", "robot_m", "person_m",
    "sonar_m", "sensors", "leak", "plume",
)  # fmt: skip
POLICIES: tuple[dict[str, Any], ...] = (
    {"name": YOU, "label": "You"},
    {"name": "fuzzy_expert", "label": OFFERED["fuzzy_expert"], "kernel": "follow_expert"},
    {"name": "ppo", "label": OFFERED["ppo"], "kernel": "follow_network"},
    {"name": UNDO_LAG, "label": GAS_ONLY["undo_lag"], "kernel": "inspect_slowly"},
    {"name": "constant:0.5", "label": OFFERED["constant:0.5"], "share": 0.5},
    {"name": "constant:1", "label": OFFERED["constant:1"], "share": 1.0},
)


class Built(NamedTuple):
    """The page, and the size of its parts [bytes]."""

    page: str
    sizes: dict[str, int]


def scene_of(settings: Settings, memory: SceneMemory, runs: list[Run]) -> dict[str, Any]:
    """Return a scene for the page."""
    found = []
    for run in runs:
        scene = view.scene_of(run, settings, view.grid_of(run)).model_dump()
        found.append({name: scene[name] for name in SHOWN})
    return {
        **memory.described(),
        "memory": packed(memory.content()),
        "starts": found,
        "decision_s": memory.config.clock.decision_s,
        "outcomes": OUTCOME_NAMES,
        "present": PRESENT,
        "policies": [each for each in POLICIES if each.get("kernel", "run_worlds") in memory.calls],
        "policy": settings.policy,
        "ghost": settings.ghost,
    }


def runs_of(settings: Settings) -> list[Run]:
    """Return the first episodes of some settings at their start."""
    episodes = range(settings.episode, settings.episode + EPISODES)
    return [Run(settings.model_copy(update={"episode": each}), Hand()) for each in episodes]


def packed(content: bytes) -> str:
    """Return bytes as base64 of what gzip makes of them."""
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode()


def script() -> str:
    """Return the page's scripts as one, without modules: those do not load from disk."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in SCRIPTS)
    return re.sub(r"^import .*$", "", re.sub(r"^export ", "", text, flags=re.M), flags=re.M)


def build() -> Built:
    """Return the whole file."""
    shared, scenes, kernels = shared_memory(), dict[str, Any](), dict[str, Kernel]()
    for name, settings in SCENES.items():
        runs = runs_of(settings)
        starts = [Start(run.info["scenario_key"], view.grid_of(run)) for run in runs]
        memory = SceneMemory(resolve(settings.scenarios())[0], starts, shared)
        scenes[name] = scene_of(settings, memory, runs)
        kernels |= memory.kernels
    module = compiled(kernels)
    data = {
        "module": packed(module), "shared": packed(shared.content()), "first": FIRST,
        "scenes": scenes,
    }  # fmt: skip
    colors = (STATIC / "style.css").read_text(encoding="utf-8").partition("* { box-sizing")[0]
    text = (HERE / "scenes.html").read_text(encoding="utf-8")
    own = (HERE / "scenes.js").read_text(encoding="utf-8")
    for name, value in (
        ("COLORS", colors), ("SCRIPT", script()), ("PAGE", own), ("DATA", json.dumps(data))
    ):  # fmt: skip
        text = text.replace(f"/* {name} */", value)
    return Built(text, {"module": len(module), "page": len(text)})


def make(app: Sphinx) -> None:
    """Make the file, unless an earlier build made it with the same code."""
    if app.builder.format != "html":
        return
    path, mark = Path(app.outdir) / FILE, Path(app.outdir) / "scenes.code"
    code = provenance.stamp(HERE) + provenance.digest(STATIC)
    if path.exists() and mark.exists() and mark.read_text(encoding="utf-8") == code:
        return
    logging.getLogger(__name__).info("compiling scenes")
    path.write_text(build().page, encoding="utf-8")
    mark.write_text(code, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Make the page when a build begins."""
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
