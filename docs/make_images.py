"""Make the pictures of README and docs: ``python docs/make_images.py``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import gymnasium
import numpy as np
import numpy.typing as npt
import PIL.Image
import PIL.ImageDraw
import PIL.ImageFont
import pygame

import hazbot_gym
from hazbot_gym import make_policy, policies
from hazbot_gym.viewer.video import Gif

IMAGES = Path(__file__).parent / "images"

# Environment, seed and decision of each picture.
PICTURES = {
    "corridor.png": ("hazbot_gym/Corridor-v1", 3, 142),
    "intersection.png": ("hazbot_gym/Intersection-v1", 47, 129),
    "doorway.png": ("hazbot_gym/Doorway-v1", 33, 62),
    "aisle.png": ("hazbot_gym/Aisle-v1", 9, 171),
    "circle.png": ("hazbot_gym/Circle-v1", 12, 100),
}

# The animation of the README: the same scenario under three policies, one below the other.
COMPARISON, COMPARED_IN = "comparison.gif", ("hazbot_gym/Intersection-v1", 2)
COMPARED = ("constant:1.0", "fuzzy_expert", "ppo")
EVERY = 4  # decisions from picture to picture
PICTURES_PER_S = 9
LASTS = 12  # pictures that the end stays for
SCENE = (0, 56, 960, 362)  # of a picture: the corridor, without the numbers below it
WIDTH, CAPTION = 560, 24  # pixels
Image = npt.NDArray[np.uint8]  # (height, width, 3)


def drive(spec: str, env_id: str, seed: int) -> list[Image]:
    """Return the pictures of an episode."""
    env: Any = gymnasium.make(env_id, render_mode="rgb_array")
    policy = make_policy(spec)
    observation, info = env.reset(seed=seed)
    pictures, decision, is_over = [panel(env, spec, info)], 0, False
    while not is_over:
        observation, _, terminated, truncated, info = env.step(policy.predict(observation)[0])
        decision, is_over = decision + 1, terminated or truncated
        if is_over or decision % EVERY == 0:
            pictures.append(panel(env, spec, info))
    return pictures


def panel(env: Any, spec: str, info: Mapping[str, Any]) -> Image:
    """Return the scene as it is now, under a caption."""
    scene = PIL.Image.fromarray(env.render()).crop(SCENE)
    height = WIDTH * scene.height // scene.width
    found = PIL.Image.new("RGB", (WIDTH, CAPTION + height), "white")
    found.paste(scene.resize((WIDTH, height), PIL.Image.Resampling.LANCZOS), (0, CAPTION))
    text = f"{spec}   {info['time_s']:.1f} s   {abs(env.unwrapped.snapshot().speed_mps):.2f} m/s"
    text += f"   {info['outcome']}" if info["outcome"] != "running" else ""
    font = PIL.ImageFont.load_default(size=15)
    PIL.ImageDraw.Draw(found).text((8, 3), text, fill="#1c2127", font=font)
    return np.asarray(found)


def comparison(path: Path) -> None:
    """Save the animation; a drive that is over stays as it ended."""
    drives = [drive(policy, *COMPARED_IN) for policy in COMPARED]
    colors = np.concatenate([picture for each in drives for picture in each[15:75:15]])
    video = Gif(path, PICTURES_PER_S, colors)
    for k in range(max(map(len, drives)) + LASTS):
        video.add(np.concatenate([each[min(k, len(each) - 1)] for each in drives]))
    video.close()


def picture(env_id: str, seed: int, decisions: int) -> pygame.Surface:
    """Return the picture of an environment after some decisions of the fuzzy expert."""
    env = gymnasium.make(env_id, render_mode="rgb_array")
    expert = policies.make("fuzzy_expert")
    observation, _ = env.reset(seed=seed)
    for _ in range(decisions):
        observation, _, terminated, truncated, _ = env.step(expert.predict(observation)[0])
        if terminated or truncated:
            break
    return pygame.surfarray.make_surface(cast(Image, env.render()).swapaxes(0, 1))


if __name__ == "__main__":
    gymnasium.register_envs(hazbot_gym)
    IMAGES.mkdir(exist_ok=True)
    for name, (env_id, seed, decisions) in PICTURES.items():
        pygame.image.save(picture(env_id, seed, decisions), IMAGES / name)
    comparison(IMAGES / COMPARISON)
