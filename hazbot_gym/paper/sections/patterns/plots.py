"""Picture of section 3.2.2: Figure 5."""

from __future__ import annotations

from matplotlib.patches import Circle, Rectangle

from hazbot_gym.core.state import PERSON_RADIUS_M, ROBOT_RADIUS_M
from hazbot_gym.paper.plot_style import BLUE, RED, new, svg
from hazbot_gym.paper.sections.patterns.experiment import ROBOT_MPS, SCENES, label

AHEAD_S = 1.6  # length of arrows


def scenes() -> str:
    """Draw the four patterns from above, with the label that each is given."""
    figure, axes = new(4.2, 2, 2)
    for scene, axis in zip(SCENES, axes.flat, strict=True):
        side = 2.0 * ROBOT_RADIUS_M
        axis.add_patch(
            Rectangle((-ROBOT_RADIUS_M, -ROBOT_RADIUS_M), side, side, color=BLUE, zorder=3)
        )
        axis.add_patch(
            Circle((scene.x, scene.y), PERSON_RADIUS_M, fill=False, color=RED, linewidth=1.6)
        )
        for x, y, vx, vy, color in (
            (0.0, 0.0, ROBOT_MPS, 0.0, BLUE),
            (scene.x, scene.y, scene.vx, scene.vy, RED),
        ):
            axis.annotate(
                "",
                xy=(x + AHEAD_S * vx, y + AHEAD_S * vy),
                xytext=(x, y),
                arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.4},
            )
        axis.set(title=f"({scene.letter}) {label(scene)}", aspect="equal", xlim=(-0.6, 3.8),
                 ylim=(-0.8, 2.3), xlabel="x [m]", ylabel="y [m]")  # fmt: skip
    return svg(figure)
