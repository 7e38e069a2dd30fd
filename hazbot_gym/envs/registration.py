"""Registration with Gymnasium: presets of one environment class."""

from __future__ import annotations

from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.after_import import after_import

NAMESPACE = "hazbot_gym"

# One sentence each, for ``hazbot list`` and the docs.
ENVIRONMENTS: dict[str, tuple[str, dict[str, object]]] = {
    "Corridor-v1": ("A corridor with side doors; people of all four patterns.", {}),
    "Crossing-v1": (
        "A stream of people across the corridor, most of whom do not yield.",
        {
            "people": {
                "family": "crossing",
                "count": [8, 12],
                "mix": [1.0, 0.0, 0.0, 0.0],
                "crossing_window_s": [-6.0, 18.0],
                "reaction_shares": [0.4, 0.6, 0.0, 0.0],
            }
        },
    ),
    "Encountering-v1": (
        "Two-way flow: most people come the other way.",
        {"people": {"family": "encountering", "count": [3, 6], "mix": [0.0, 0.7, 0.2, 0.1]}},
    ),
    "Leading-v1": (
        "Slow people walk ahead in the same direction, and can be neither passed nor pushed.",
        {"people": {"family": "leading", "count": [2, 4], "mix": [0.2, 0.3, 0.5, 0.0]}},
    ),
    "Confronting-v1": (
        "A person comes straight at the robot.",
        {"people": {"family": "confronting", "count": [1, 3]}},
    ),
    "Circle-v1": (
        "The paper's circle; people walk across it.",
        {"place": "circle", "max_episode_steps": 2000, "people": {"count": [4, 8]}},
    ),
    "Intersection-v1": (
        "Two corridors cross behind blind corners; people walk across.",
        {
            "place": "intersection",
            "people": {
                "family": "crossing",
                "count": [6, 10],
                "mix": [0.9, 0.1, 0.0, 0.0],
                "crossing_window_s": [-4.0, 10.0],
                "reaction_shares": [0.5, 0.5, 0.0, 0.0],
            },
        },
    ),
    "Doorway-v1": (
        "A doorway wide enough for one at a time, with people in both directions.",
        {
            "place": "doorway",
            "people": {"family": "encountering", "count": [4, 8], "mix": [0.0, 0.7, 0.3, 0.0]},
        },
    ),
    "Aisle-v1": (
        "An L-shaped aisle between shelves, with a blind corner.",
        {"place": "aisle", "people": {"count": [2, 5]}},
    ),
    "Inspection-v1": (
        "A corridor with people, and in 70 % of episodes a gas leak to be found.",
        {"gas": {}},
    ),
    "InspectionEmpty-v1": (
        "The same without people: how fast to drive for the gas sensor alone.",
        {"gas": {}, "people": {"count": [0, 0]}},
    ),
    "Replay-v1": (
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
    import gymnasium

    for name, (_, preset) in ENVIRONMENTS.items():
        env_id = f"{NAMESPACE}/{name}"
        if env_id not in gymnasium.registry:
            gymnasium.register(
                id=env_id,
                entry_point="hazbot_gym.envs.corridor:CorridorEnv",
                vector_entry_point="hazbot_gym.envs.vector:CorridorVectorEnv",
                kwargs={"preset": preset},
            )


def register_with_gymnasium() -> None:
    """Register all environments as soon as Gymnasium is imported, which a robot need not do."""
    after_import("gymnasium", register_environments)
