"""Make the pictures of README and docs: ``python docs/make_images.py``."""

from __future__ import annotations

from pathlib import Path

import gymnasium
import pygame

import hazbot_gym
from hazbot_gym import policies

IMAGES = Path(__file__).parent / "images"

# Environment, seed and decision of each picture.
PICTURES = {
    "corridor.png": ("hazbot_gym/Corridor-v0", 3, 142),
    "intersection.png": ("hazbot_gym/Intersection-v0", 47, 129),
    "doorway.png": ("hazbot_gym/Doorway-v0", 33, 62),
    "aisle.png": ("hazbot_gym/Aisle-v0", 9, 171),
    "circle.png": ("hazbot_gym/Circle-v0", 12, 100),
}


def picture(env_id: str, seed: int, decisions: int) -> pygame.Surface:
    """Return the picture of an environment after some decisions of the fuzzy expert."""
    env = gymnasium.make(env_id, render_mode="rgb_array")
    expert = policies.make("fuzzy_expert")
    observation, _ = env.reset(seed=seed)
    for _ in range(decisions):
        observation, _, terminated, truncated, _ = env.step(expert.predict(observation)[0])
        if terminated or truncated:
            break
    return pygame.surfarray.make_surface(env.render().swapaxes(0, 1))


if __name__ == "__main__":
    gymnasium.register_envs(hazbot_gym)
    IMAGES.mkdir(exist_ok=True)
    for name, (env_id, seed, decisions) in PICTURES.items():
        pygame.image.save(picture(env_id, seed, decisions), IMAGES / name)
