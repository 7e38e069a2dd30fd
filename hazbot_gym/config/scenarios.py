"""Named scenarios of the published paper, as deltas on the default config."""

from __future__ import annotations

import math

from hazbot_gym.config.deltas import merge
from hazbot_gym.utils.json_object import JsonObject


def _paper_scenario(x_m: float, y_m: float, vx_mps: float, vy_mps: float) -> dict[str, object]:
    """Return a scenario of the paper: one scripted walker, an ideal drive already at speed."""
    walker = {"x_m": x_m, "y_m": y_m, "vx_mps": vx_mps, "vy_mps": vy_mps}
    return {
        "place": "open",
        "people": {"model": "scripted", "walkers": [walker]},
        "drive": {"wheel_loop": "ideal", "start_speed_mps": 0.5},
        "sensors": {
            "ultrasonic": {"noise_m": 0.0},
            "tracker": {"position_noise_m": 0.0, "velocity_noise_mps": 0.0},
        },
    }


# The paper's circle (Table 3): at rest at its lowest point, the reference at full speed at once.
# Plant B gives the fuzzy-PID's published figures.
_CIRCLE = {
    "place": "circle",
    "people": {"count": [0, 0]},
    "drive": {
        "plant": "B",
        "acceleration_mps2": 1e9,
        "deceleration_mps2": 1e9,
        "wheel_noise_radps": 0.0,
        "heading_noise_rad": 0.0,
    },
}

# A person walks in the opposite direction beside the circle; the position is our choice.
_HUMAN_ON_THE_WAY = {
    "max_episode_steps": 800,
    "people": {
        "model": "scripted",
        "count": [1, 1],
        "walkers": [{"x_m": 4.7, "y_m": 9.8, "vx_mps": 0.0, "vy_mps": -0.5}],
    },
    "drive": {
        "acceleration_mps2": 0.5,
        "deceleration_mps2": 1.0,
        "wheel_noise_radps": 0.01,
        "heading_noise_rad": 0.002,
    },
}

_AS_BUILT = {  # realistic drive, and a robot that starts with the people
    "drive": {"wheel_loop": "fuzzy_pid", "plant": "B", "start_speed_mps": 0.0},
    "sensors": {
        "ultrasonic": {"noise_m": 0.03},
        "tracker": {"position_noise_m": 0.03, "velocity_noise_mps": 0.05},
    },
}

# The front wall of the crossing experiment; its position is not printed.
_FRONT_WALL = {
    "place_options": {"length_m": 8.0, "end_wall_m": 0.35},
    "drive": {"reflex_stop_m": 0.5},
}

_C_STAR_RAD = math.radians(-66.9)
_E_STAR = _paper_scenario(4.479, 0.800, -0.5, 0.0)
_E_FAR = _paper_scenario(5.442, 0.800, -0.5, 0.0)
_C_STAR = _paper_scenario(2.750, 4.763, 0.5 * math.cos(_C_STAR_RAD), 0.5 * math.sin(_C_STAR_RAD))
SCENARIOS: dict[str, JsonObject] = {
    "E*": _E_STAR,  # encountering, the simulation
    "E5.5": _E_FAR,  # encountering, the experiment's distance
    "C*": _C_STAR,  # crossing
    "C90": _paper_scenario(3.889, 3.889, 0.0, -0.5),  # crossing at a right angle
    "E-experiment": merge(_E_FAR, _AS_BUILT),
    "C-experiment": merge(_C_STAR, _AS_BUILT),
    "C-experiment+wall": merge(merge(_C_STAR, _AS_BUILT), _FRONT_WALL),
    "circle": _CIRCLE,  # nobody there
    "circle+human": merge(_CIRCLE, _HUMAN_ON_THE_WAY),  # the paper's Figure 19
}
