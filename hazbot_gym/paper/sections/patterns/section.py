"""Section 3.2.2: behaviour patterns."""

from __future__ import annotations

from hazbot_gym.core.proxemics import SOCIAL_M
from hazbot_gym.paper.chapter import Chapter, Picture, Table
from hazbot_gym.paper.sections.patterns import plots
from hazbot_gym.paper.sections.patterns.experiment import SCENES, label, limits


def chapter(quick: bool) -> Chapter:
    """Return the section; it takes no time in either form."""
    labels = {scene.meant: label(scene) for scene in SCENES}
    return Chapter(
        number="3.2.2",
        title="Behavioral Pattern Analysis",
        here={"patterns": len(set(labels.values()))},
        record={"labels": labels, "limits": limits()},
        text=(
            "The paper names four patterns and draws them (Figure 5), but does not say how the "
            "robot distinguishes them. Here the pattern is determined by the headings, the "
            "bearing, and the distance at which robot and human would pass if both continued "
            f"straight. It is assigned when a human comes within {SOCIAL_M:g} m and kept while "
            "the human stays within that distance. The same definition is used to count the "
            "patterns among recorded pedestrians (docs/people.md).",
        ),
        tables=(
            Table(
                "Limits between the patterns (our choice)",
                ("limit", "value"),
                [(name, f"{value:g}") for name, value in limits().items()],
            ),
        ),
        pictures=(
            Picture(
                "patterns",
                "Figure 5",
                "The four patterns: the robot (square) and a human (circle), with their "
                f"positions {plots.AHEAD_S:g} s later. The titles are the patterns that the "
                "library recognizes.",
                plots.scenes(),
            ),
        ),
    )
