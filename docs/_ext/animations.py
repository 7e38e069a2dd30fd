"""A short animation of each environment, drawn by the package's own renderer at build time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
from PIL import Image
from sphinx.application import Sphinx
from sphinx.util import logging

import hazbot_gym
from hazbot_gym.envs.panel import STRIP_ROW_PX, height_px
from hazbot_gym.envs.registration import ENVIRONMENTS, full_id
from hazbot_gym.utils import provenance

FOLDER = "_animations"
SEEDS = {
    **{"Corridor-v1": 3, "Intersection-v1": 47, "Doorway-v1": 33, "Aisle-v1": 9, "Circle-v1": 12},
    **{"Inspection-v1": 5, "InspectionEmpty-v1": 5},
}
# Animations of other pages than that of environments: id and seed.
OTHERS = {"gas": ("Inspection-v1", 7)}
SEED = 3  # of environments that are not named above
# Decisions around the one at which a person is nearest, with gas of the largest reading
BEFORE, AFTER = 60, 36
EXPERT, GAS_EXPERT = "fuzzy_expert", "undo_lag:people=fuzzy_expert"
EVERY, SHOWN_MS = 2, 100  # decisions a picture, and how long it is shown: twice real time
WIDTH_PX = 560
ROW_PX = 14  # from the middle of the strip of gas to its upper edge


def drive(env: Any, seed: int, decisions: range | None = None) -> Iterator[float | Image.Image]:
    """Yield a number after each decision, least where the picture tells most, or some pictures.

    It is the distance to the nearest person, with gas less the reading of the sensor.
    """
    has_gas = env.unwrapped.config.gas is not None
    expert = hazbot_gym.make_policy(GAS_EXPERT if has_gas else EXPERT)
    observation, _ = env.reset(seed=seed)
    decision, has_ended = 0, False
    while not has_ended and (decisions is None or decision < decisions.stop):
        observation, _, terminated, truncated, _ = env.step(expert.predict(observation)[0])
        has_ended, decision = terminated or truncated, decision + 1
        if decisions is None:
            state = env.unwrapped.snapshot()
            people = state.people
            if has_gas:
                yield -float(state.gas["smell"]["reading"][0])
                continue
            yield float(np.hypot(people["x"] - state.x, people["y"] - state.y).min(initial=np.inf))
        elif decision in decisions:
            picture = env.render()  # shown without the panel, but with the strip of gas
            scene, panel = np.split(picture, [-height_px(has_strip=has_gas)])
            strip = panel[round(STRIP_ROW_PX) - ROW_PX :] if has_gas else panel[:0]
            yield Image.fromarray(np.concatenate([scene, strip]))


def animate(name: str, folder: Path) -> None:
    """Write NAME.webp, and NAME-still.webp for readers who asked for less motion."""
    env_id, seed = OTHERS.get(name, (name, SEEDS.get(name, SEED)))
    env = gymnasium.make(full_id(env_id), render_mode="rgb_array")
    nearest = int(np.argmin(cast(list[float], list(drive(env, seed)))))
    window = range(max(nearest - BEFORE, 0), nearest + AFTER, EVERY)
    pictures = [
        each.resize((WIDTH_PX, round(each.height * WIDTH_PX / each.width)), Image.Resampling.BOX)
        for each in drive(env, seed, window)
        if isinstance(each, Image.Image)
    ]
    env.close()
    still = pictures[min(BEFORE // EVERY, len(pictures) - 1)]
    still.save(folder / f"{name}-still.webp", quality=70)
    options: dict[str, Any] = {"duration": SHOWN_MS, "loop": 0, "quality": 45, "method": 2}
    pictures[0].save(folder / f"{name}.webp", save_all=True, append_images=pictures[1:], **options)


def html(name: str, sentence: str) -> str:
    """Return the HTML that shows an animation, or a still picture where motion is unwelcome."""
    return (
        f'<picture><source media="(prefers-reduced-motion: reduce)" srcset="{FOLDER}/{name}-still.'
        f'webp"><img class="animation" loading="lazy" src="{FOLDER}/{name}.webp" '
        f'alt="{name}: {sentence}"></picture>'
    )


def draw(app: Sphinx) -> None:
    """Draw what no earlier build drew with the same code."""
    if app.builder.format != "html":
        return
    folder = Path(app.outdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    drawn_with, code = folder / "code.txt", provenance.stamp(Path(__file__))
    if drawn_with.exists() and drawn_with.read_text(encoding="utf-8") == code:
        return
    for name in (*ENVIRONMENTS, *OTHERS):
        logging.getLogger(__name__).info("drawing %s", name)
        animate(name, folder)
    drawn_with.write_text(code, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Draw when a build begins."""
    app.connect("builder-inited", draw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
