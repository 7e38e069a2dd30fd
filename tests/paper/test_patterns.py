from __future__ import annotations

import pytest

from hazbot_gym.core.state import PATTERN_NAMES
from hazbot_gym.paper.sections.patterns.experiment import SCENES, Scene, label


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.meant)
def test_scene_is_recognised_as_the_paper_describes_it(scene: Scene) -> None:
    assert label(scene) == scene.meant


def test_there_is_a_scene_of_every_pattern_in_the_order_of_figure_5() -> None:
    assert tuple(scene.meant for scene in SCENES) == PATTERN_NAMES
    assert [scene.letter for scene in SCENES] == list("abcd")


def test_somebody_behind_has_no_pattern() -> None:
    assert label(SCENES[0]._replace(x=-2.0)) == "none"
