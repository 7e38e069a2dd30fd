"""Registration with Gymnasium: presets of one environment class."""

from __future__ import annotations

import gymnasium

from hazbot_gym.errors import InvalidInput

NAMESPACE = "hazbot_gym"

# One sentence each, for ``hazbot list`` and the docs.
ENVIRONMENTS: dict[str, tuple[str, dict[str, object]]] = {
    "Corridor-v0": ("A corridor with side doors; people of all four patterns.", {}),
    "Crossing-v0": (
        "A person crosses the corridor through the side doors.",
        {"people": {"family": "crossing", "count": [1, 3]}},
    ),
    "Encountering-v0": (
        "A person comes the other way and intends to pass.",
        {"people": {"family": "encountering", "count": [1, 3]}},
    ),
    "Leading-v0": (
        "A slower person walks ahead in the same direction.",
        {"people": {"family": "leading", "count": [1, 3]}},
    ),
    "Confronting-v0": (
        "A person comes straight at the robot.",
        {"people": {"family": "confronting", "count": [1, 3]}},
    ),
    "Circle-v0": (
        "The paper's circle; people walk across it.",
        {"place": "circle", "max_episode_steps": 1000, "people": {"count": [2, 4]}},
    ),
    "Intersection-v0": (
        "Two corridors cross behind blind corners.",
        {"place": "intersection", "people": {"family": "crossing", "count": [2, 5]}},
    ),
    "Doorway-v0": (
        "A doorway wide enough for one at a time.",
        {"place": "doorway", "people": {"family": "encountering", "count": [1, 4]}},
    ),
    "Aisle-v0": (
        "An L-shaped aisle between shelves, with a blind corner.",
        {"place": "aisle", "people": {"count": [1, 4]}},
    ),
    "Replay-v0": (
        "Recorded people; without a track file, a small synthetic recording.",
        {"people": {"model": "replay"}},
    ),
}


def full_id(name: str) -> str:
    """Return an id with the namespace, which is optional for users.

    Raises:
        InvalidInput: The environment is unknown.
    """
    short = str(name).removeprefix(f"{NAMESPACE}/")
    if short not in ENVIRONMENTS:
        allowed = ", ".join(f"{NAMESPACE}/{each}" for each in ENVIRONMENTS)
        raise InvalidInput(f"env: given {name!r}, allowed are {allowed}, or without {NAMESPACE}/")
    return f"{NAMESPACE}/{short}"


def register_environments() -> None:
    """Register all environments; idempotent."""
    for name, (_, preset) in ENVIRONMENTS.items():
        env_id = f"{NAMESPACE}/{name}"
        if env_id not in gymnasium.registry:
            gymnasium.register(
                id=env_id,
                entry_point="hazbot_gym.envs.corridor:CorridorEnv",
                vector_entry_point="hazbot_gym.envs.vector:CorridorVectorEnv",
                kwargs={"preset": preset},
            )
