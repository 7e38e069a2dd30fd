"""Section 3.2.2: the four patterns of Figure 5 as scenes, labelled by geometry."""

from __future__ import annotations

import math
from typing import NamedTuple

from hazbot_gym.core.patterns import Thresholds, classify
from hazbot_gym.core.state import NO_PATTERN, PATTERN_NAMES


class Scene(NamedTuple):
    """A human in front of a robot that drives along x at 0.5 m/s from the origin."""

    letter: str  # of Figure 5
    meant: str  # the pattern that the paper describes
    x: float  # of the human [m]
    y: float
    vx: float  # [m/s]
    vy: float


SCENES = (
    Scene("a", "crossing", 2.4, 1.8, 0.0, -0.5),
    Scene("b", "encountering", 3.2, 0.8, -0.5, 0.0),
    Scene("c", "leading", 1.8, 0.1, 0.4, 0.0),
    Scene("d", "confronting", 3.2, 0.1, -0.5, 0.0),
)
ROBOT_MPS = 0.5


def label(scene: Scene) -> str:
    """Return the recognized pattern of a scene."""
    code = classify(scene.x, scene.y, 0.0, ROBOT_MPS, scene.vx, scene.vy, Thresholds())
    return "none" if code == NO_PATTERN else PATTERN_NAMES[code]


def limits() -> dict[str, float]:
    """Return the thresholds between patterns [deg, m, m/s]."""
    thresholds = Thresholds()
    return {
        "headings alike within [deg]": math.degrees(thresholds.aligned_rad),
        "headings opposed from [deg]": math.degrees(thresholds.opposed_rad),
        "in front up to a bearing of [deg]": math.degrees(thresholds.front_rad),
        "head-on if they would pass within [m]": thresholds.head_on_m,
        "standing below [m/s]": thresholds.moving_mps,
    }
