"""Recorded scenes for the front page: runs of the page's own session, drawn by its own scripts.

One file holds everything, so that it also works where it is opened from disk.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

from hazbot_gym.live.policies import Policies
from hazbot_gym.live.session import Session
from hazbot_gym.live.settings import Settings
from hazbot_gym.utils import provenance

FILE = "scenes.html"
HERE = Path(__file__).parent
STATIC = HERE.parents[1] / "hazbot_gym" / "live" / "static"
SCRIPTS = ("shapes.js", "floor.js", "place.js", "motion.js")  # each after what it imports
SCENES = {
    "The paper's crossing": Settings(env="C*", policy="fuzzy_expert", ghost="ppo"),
    "A doorway": Settings(env="Doorway-v1", policy="fuzzy_expert", ghost="ppo"),
    "An inspection": Settings(
        env="Inspection-v1", seed=1, policy="undo_lag:people=fuzzy_expert", ghost="fuzzy_expert"
    ),
}
MOST_DECISIONS = 800
PLUME_EVERY = 4  # of the pictures of the gas that the page gets
# Of a frame, what the place draws.
SHOWN = ("decision", "time_s", "pose", "speed", "people", "ranges", "outcome", "ghost")


def record(settings: Settings) -> dict[str, Any]:
    """Return a scene and its frames, for the page's scripts."""
    session = Session(Policies(settings.policy, settings.ghost), settings)
    frames, plumes = [session.frame()], 0
    while not session.run.is_over and len(frames) < MOST_DECISIONS:
        session.tick()
        frames.append(session.frame())
    found = []
    for frame in frames:
        shown = {name: frame.model_dump()[name] for name in SHOWN}
        if frame.plume is not None:
            shown |= {} if plumes % PLUME_EVERY else {"plume": frame.plume}
            plumes += 1
        found.append(shown)
    return {"scene": session.scene().model_dump(), "frames": found}


def script() -> str:
    """Return the page's scripts as one, without modules: those do not load from disk."""
    text = "\n".join((STATIC / name).read_text(encoding="utf-8") for name in SCRIPTS)
    return re.sub(r"^import .*$", "", re.sub(r"^export ", "", text, flags=re.M), flags=re.M)


def page() -> str:
    """Return the whole file."""
    colors = (STATIC / "style.css").read_text(encoding="utf-8").partition("* { box-sizing")[0]
    data = json.dumps({name: record(settings) for name, settings in SCENES.items()})
    text = (HERE / "scenes.html").read_text(encoding="utf-8")
    for name, value in (("COLORS", colors), ("DATA", data), ("SCRIPT", script())):
        text = text.replace(f"/* {name} */", value)
    return text


def make(app: Sphinx) -> None:
    """Make the file, unless an earlier build made it with the same code."""
    if app.builder.format != "html":
        return
    path, mark = Path(app.outdir) / FILE, Path(app.outdir) / "scenes.code"
    code = provenance.stamp(HERE) + provenance.digest(STATIC)
    if path.exists() and mark.exists() and mark.read_text(encoding="utf-8") == code:
        return
    logging.getLogger(__name__).info("recording scenes")
    path.write_text(page(), encoding="utf-8")
    mark.write_text(code, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Record when a build begins."""
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
