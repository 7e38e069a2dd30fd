"""The view shows the whole path at one scale, or follows the robot."""

from __future__ import annotations

import numpy as np
import pytest

from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import Floats
from hazbot_gym.envs.frame import LARGEST, MULTIPLE, PX_PER_M, SMALLEST, View, size_of, view_of
from hazbot_gym.task.places import PLACES, load_place


@pytest.mark.parametrize("name", PLACES)
def test_a_place_is_seen_whole_and_at_the_common_scale(name: str) -> None:
    place = load_place(name)
    width, height = size_of(place)

    view = view_of(place, width, height)

    assert view is not None
    assert view.px_per_m == PX_PER_M
    starts: Floats = np.column_stack([place.path["x"], place.path["y"]])
    assert np.all((view.pixels(starts) > 0) & (view.pixels(starts) < [width, height]))


@pytest.mark.parametrize("length_m", [0.5, 12.0, 200.0])
def test_sizes_are_within_limits_and_fit_for_video_codecs(length_m: float) -> None:
    size = size_of(load_place("open", {"length_m": length_m}))

    assert size[0] % MULTIPLE == size[1] % MULTIPLE == 0
    assert SMALLEST <= size <= LARGEST


def test_a_path_too_long_to_see_has_no_view_of_the_whole() -> None:
    path = straight_path(np.array([[0.0, 0.0], [100.0, 0.0]]))
    place = load_place("open")._replace(path=path)

    assert view_of(place, *size_of(place)) is None


def test_left_of_the_robot_is_up_in_the_picture() -> None:
    view = View(1.0, 2.0, 10.0, 200, 100)

    assert view.pixels(np.array([[1.0, 2.0], [2.0, 3.0]])).tolist() == [
        [100.0, 50.0],
        [110.0, 40.0],
    ]
