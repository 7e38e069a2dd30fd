"""Section 2: the robot, its sensors and its wheels."""

from __future__ import annotations

from hazbot_gym.core.sensor_ring import PAPER, is_ahead
from hazbot_gym.core.state import LEFT, RIGHT
from hazbot_gym.paper.chapter import Chapter


def chapter(quick: bool) -> Chapter:
    """Return the section; nothing in it is measured."""
    in_front = sum(map(is_ahead, PAPER))
    return Chapter(
        number="2",
        title="Overall Design of Mobile Inspection Robot",
        here={
            "sonars": len(PAPER),
            "sonars_in_front": in_front,
            "sonars_each_side": (len(PAPER) - in_front) / 2,
            "driving_wheels": len({RIGHT, LEFT}),
            "passive_wheels": 1,
        },
        record={},
        text=(
            "The paper describes a chassis with two driving wheels in front, passive wheels "
            f"behind, {len(PAPER)} ultrasonic sensors, a grayscale sensor that detects the "
            "line on the floor, and a camera. Here the robot is a disc with the same wheels and "
            "sensors. The camera is left out, because the paper's strategy does not use it.",
        ),
    )
