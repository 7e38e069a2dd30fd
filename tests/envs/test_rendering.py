"""The picture shows what is there, where it is."""

from __future__ import annotations

import builtins
import importlib
import sys
from typing import Any

import numpy as np
import pytest

from hazbot_gym.core.geometry import straight_path
from hazbot_gym.core.state import (
    CONFRONTING,
    CROSSING,
    GONE,
    NO_PATTERN,
    PERSON,
    PRESENT,
    WAITING,
    Floats,
    Records,
    records,
)
from hazbot_gym.envs import rendering
from hazbot_gym.envs.rendering import NOBODY, PEOPLE, Frame, Image, draw, view_of
from hazbot_gym.errors import MissingExtra
from hazbot_gym.task.places import load_place

SHOULDER_M = 0.14  # off the head, on the shoulders of somebody who walks along x


def someone(x: float, y: float, status: int = PRESENT) -> Records:
    person = records(PERSON, 1)
    person["x"], person["y"], person["vx"], person["radius"] = x, y, -1.0, 0.2
    person["status"] = status
    return person


def a_frame(people: Records, pattern: int = CROSSING, **changes: Any) -> Frame:
    frame = Frame(
        place=load_place("corridor"),
        x_m=2.0,
        y_m=0.0,
        theta_rad=0.0,
        people=people,
        patterns=[pattern] * len(people),
        ranges_m=np.full(4, 1.0),
    )
    return frame._replace(**changes)


def color_at(frame: Frame, image: Image, x: float, y: float) -> list[int]:
    height, width, _ = image.shape
    column, row = view_of(frame, width=width, height=height).pixels(np.array([x, y]))
    return image[round(row), round(column)].tolist()


@pytest.mark.parametrize(("width", "height"), [(960, 480), (320, 200)])
def test_picture_has_the_asked_size_and_is_not_blank(width: int, height: int) -> None:
    image = draw(a_frame(someone(5.0, 0.0)), width=width, height=height)

    assert image.shape == (height, width, 3)
    assert image.dtype == np.uint8
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20


@pytest.mark.parametrize(
    ("pattern", "color"),
    [(CROSSING, PEOPLE[0]), (CONFRONTING, PEOPLE[3]), (NO_PATTERN, NOBODY)],
)
def test_person_wears_the_color_of_the_pattern(pattern: int, color: tuple[int, ...]) -> None:
    frame = a_frame(someone(5.0, 0.5), pattern)

    assert color_at(frame, draw(frame), 5.0, 0.5 + SHOULDER_M) == list(color)


def test_mirrored_world_gives_the_mirrored_colors() -> None:
    left, right = a_frame(someone(5.0, 0.5)), a_frame(someone(5.0, -0.5))
    picture_left, picture_right = draw(left), draw(right)

    for y in (0.5 + SHOULDER_M, -0.5 - SHOULDER_M):
        here, there = color_at(left, picture_left, 5.0, y), color_at(right, picture_right, 5.0, -y)
        assert here == there
    assert color_at(left, picture_left, 5.0, -0.5 - SHOULDER_M) != list(PEOPLE[0])


@pytest.mark.parametrize("status", [WAITING, GONE])
def test_people_who_are_not_there_are_not_drawn(status: int) -> None:
    empty = draw(a_frame(records(PERSON, 0)))

    assert np.array_equal(draw(a_frame(someone(5.0, 0.5, status))), empty)


@pytest.mark.parametrize(
    "change",
    [
        {"theta_rad": 0.5},
        {"x_m": 3.0},
        {"ranges_m": np.full(4, 2.0)},
        {"castor_rad": 0.5},
        {"trail": np.array([[0.0, 0.0], [2.0, 0.5]])},
        {"speed_mps": 0.4},
        {"command_mps": 0.4},
        {"time_s": 1.0},
        {"outcome": "contact_wall"},
    ],
)
def test_every_part_of_the_state_is_visible(change: dict[str, Any]) -> None:
    frame = a_frame(someone(5.0, 0.5))

    assert not np.array_equal(draw(frame), draw(frame._replace(**change)))


def test_drawing_the_same_frame_again_gives_the_same_picture_in_its_own_memory() -> None:
    frame = a_frame(someone(5.0, 0.5))
    first, second = draw(frame), draw(frame)

    assert np.array_equal(first, second)
    assert not np.shares_memory(first, second)


@pytest.mark.parametrize(
    "place", ["open", "corridor", "intersection", "doorway", "circle", "aisle"]
)
def test_view_shows_the_whole_path_of_a_small_place(place: str) -> None:
    frame = a_frame(someone(5.0, 0.5), place=load_place(place))
    starts: Floats = np.column_stack([frame.place.path["x"], frame.place.path["y"]])

    pixels = view_of(frame).pixels(starts)

    assert np.all((pixels > 0) & (pixels < [960, 480]))


def test_view_follows_the_robot_along_a_path_too_long_to_fit() -> None:
    path = straight_path(np.array([[0.0, 0.0], [100.0, 0.0]]))
    frame = a_frame(someone(5.0, 0.5), place=load_place("open")._replace(path=path))

    view = view_of(frame._replace(x_m=70.0))

    assert view.pixels(np.array([70.0, 0.0])).tolist() == [480.0, 240.0]


def test_missing_pygame_names_the_install_command(monkeypatch: pytest.MonkeyPatch) -> None:
    real_import = builtins.__import__

    def without_pygame(name: str, *args: Any, **kwargs: Any) -> Any:
        if name == "pygame":
            raise ImportError(name)
        return real_import(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without_pygame)
    monkeypatch.delitem(sys.modules, "hazbot_gym.envs.rendering")

    with pytest.raises(MissingExtra, match=r"pip install 'hazbot-gym\[render\]'"):
        importlib.import_module("hazbot_gym.envs.rendering")
    assert rendering.__name__ not in sys.modules
