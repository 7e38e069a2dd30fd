"""The picture shows what is there, where it is."""

from __future__ import annotations

import builtins
import importlib
import itertools
import sys
from typing import Any

import numpy as np
import pytest

from hazbot_gym.config import make_config
from hazbot_gym.core.geometry import sample_path
from hazbot_gym.core.sensor_ring import SIX
from hazbot_gym.core.state import (
    CONFRONTING,
    CROSSING,
    GONE,
    NO_PATTERN,
    PERSON,
    PRESENT,
    WAITING,
    Records,
    records,
)
from hazbot_gym.core.state import GAS as GAS_RECORD
from hazbot_gym.envs import canvas
from hazbot_gym.envs.canvas import FLOOR, GAS, INK, NOBODY, OUTSIDE, PEOPLE, Image, mixed
from hazbot_gym.envs.frame import Frame, between, view_of
from hazbot_gym.envs.panel import HEIGHT_PX, STRIP_PX, height_px
from hazbot_gym.envs.plume import OPAQUE, GasFrame, gas_frame_of
from hazbot_gym.envs.rendering import Painter, draw
from hazbot_gym.envs.scene import INTIMATE, PERSONAL
from hazbot_gym.errors import MissingExtra
from hazbot_gym.task.leak import leak_point
from hazbot_gym.task.places import PLACES, load_place
from tests.refusals import refused

SHOULDER_M = 0.14  # off the head, on the shoulders of somebody who walks along x
CORRIDOR = load_place("corridor")


def someone(x: float, y: float, status: int = PRESENT) -> Records:
    person = records(PERSON, 1)
    person["x"], person["y"], person["vx"], person["radius"] = x, y, -1.0, 0.2
    person["status"] = status
    return person


def a_frame(people: Records, pattern: int = CROSSING, **changes: Any) -> Frame:
    frame = Frame(
        place=CORRIDOR,
        x_m=2.0,
        y_m=0.0,
        theta_rad=0.0,
        people=people,
        patterns=[pattern] * len(people),
        ranges_m=np.full(4, 1.0),
        terms={"progress": 0.5, "intrusion": 0.0},
    )
    return frame._replace(**changes)


def color_at(frame: Frame, image: Image, x: float, y: float) -> list[int]:
    height, width, _ = image.shape
    view = view_of(frame.place, width, height - height_px(has_strip=frame.gas is not None))
    assert view is not None
    column, row = view.pixels(np.array([x, y]))
    return image[round(row), round(column)].tolist()


@pytest.mark.parametrize("place", PLACES)
def test_a_picture_is_an_image_that_is_not_blank(place: str) -> None:
    image = draw(a_frame(someone(5.0, 0.0), place=load_place(place)))

    assert image.dtype == np.uint8
    assert image.ndim == 3
    assert image.shape[2] == 3
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20


def test_walls_part_the_floor_from_what_lies_behind_them() -> None:
    frame = a_frame(records(PERSON, 0))
    image = draw(frame)

    assert color_at(frame, image, 10.0, 0.5) == list(FLOOR)
    assert color_at(frame, image, 10.0, 1.2) == list(INK)
    assert color_at(frame, image, 10.0, 2.0) == list(OUTSIDE)


def test_without_walls_everything_is_floor() -> None:
    frame = a_frame(records(PERSON, 0), place=load_place("open"))

    assert color_at(frame, draw(frame), 10.0, 2.0) == list(FLOOR)


@pytest.mark.parametrize(("clearance_m", "color"), [(0.3, INTIMATE), (0.8, PERSONAL), (1.5, FLOOR)])
def test_halls_zones_are_shaded(clearance_m: float, color: tuple[int, ...]) -> None:
    frame = a_frame(someone(8.0, 0.3))

    seen = color_at(frame, draw(frame), 8.0 + 0.2 + clearance_m, 0.3)

    assert np.allclose(seen, color, atol=3)


@pytest.mark.parametrize(
    ("pattern", "color"),
    [(CROSSING, PEOPLE[0]), (CONFRONTING, PEOPLE[3]), (NO_PATTERN, NOBODY)],
)
def test_person_wears_the_color_of_the_pattern(pattern: int, color: tuple[int, ...]) -> None:
    frame = a_frame(someone(5.0, 0.5), pattern)

    assert color_at(frame, draw(frame), 5.0, 0.5 + SHOULDER_M) == list(color)


def test_between_two_decisions_robot_and_people_are_halfway() -> None:
    before = a_frame(someone(5.0, 0.5), x_m=2.0, outcome="", time_s=1.0)
    after = a_frame(someone(4.0, 0.7), x_m=2.2, outcome="arrived", time_s=1.1)

    frame = between(before, after, 0.5)

    assert frame.x_m == pytest.approx(2.1)
    assert frame.people[["x", "y"]].tolist() == [pytest.approx((4.5, 0.6))]
    assert (frame.outcome, frame.time_s) == ("", 1.0)
    assert before.people["x"].tolist() == [5.0]
    gone = a_frame(someone(9.0, 0.7, GONE))
    assert between(before, gone, 0.5).people["x"].tolist() == [5.0]


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
    ("change", "is_in_panel"),
    [
        ({"theta_rad": 0.5}, False),
        ({"x_m": 3.0}, False),
        ({"ranges_m": np.full(4, 2.0)}, False),
        ({"ranges_m": np.full(6, 1.0), "ring": SIX}, False),
        ({"castor_rad": 0.5}, False),
        ({"trail": np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 0.5]])}, False),
        ({"patterns": [CONFRONTING]}, False),
        ({"people": someone(5.5, 0.5)}, False),
        ({"speed_mps": 0.4}, True),
        ({"command_mps": 0.4}, True),
        ({"time_s": 1.0}, True),
        ({"outcome": "contact_wall"}, True),
        ({"terms": {"progress": 0.4, "intrusion": 0.0}}, True),
        ({"terms": {"progress": 0.5, "intrusion": -1.0}}, True),
        ({"total_reward": 10.0}, True),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_every_part_of_the_state_is_visible_in_its_place(
    change: dict[str, Any], is_in_panel: bool
) -> None:
    frame = a_frame(someone(5.0, 0.5))
    is_changed = (draw(frame) != draw(frame._replace(**change))).any(axis=2)

    assert is_changed[-HEIGHT_PX:].any() == is_in_panel
    assert is_changed[:-HEIGHT_PX].any() != is_in_panel


def test_a_painter_forgets_the_last_frame() -> None:
    painter, frame = Painter(CORRIDOR), a_frame(someone(5.0, 0.5))
    first = painter.paint(frame)
    painter.paint(a_frame(someone(8.0, 0.5), x_m=4.0, outcome="arrived", time_s=9.0))

    again = painter.paint(frame)

    assert np.array_equal(first, again)
    assert np.array_equal(first, draw(frame))
    assert not np.shares_memory(first, again)


def test_a_painter_keeps_its_size_in_another_place() -> None:
    painter = Painter(CORRIDOR)
    pictures = [
        painter.paint(a_frame(someone(5.0, 0.5), place=place))
        for place in (CORRIDOR, load_place("circle"), load_place("open", {"length_m": 100.0}))
    ]

    for one, other in itertools.pairwise(pictures):
        assert one.shape == other.shape
        assert not np.array_equal(one, other)


def test_the_view_of_a_long_path_moves_with_the_robot() -> None:
    long = load_place("open", {"length_m": 100.0})
    painter = Painter(long)
    here, there = (
        painter.paint(a_frame(someone(x + 2.0, 0.5), place=long, x_m=x, time_s=1.0))
        for x in (30.0, 30.0 + 4 * 0.375)  # a whole number of dashes further
    )

    assert np.mean(here != there) < 0.001


# Machado, Oliveira and Fernandes 2009, severity 1: how linear RGB is seen.
VISION = {
    "full": np.eye(3),
    "without red": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "without green": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "without blue": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}


def lab(linear: np.ndarray) -> np.ndarray:
    """Return CIE L*a*b* of linear sRGB."""
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    f = np.cbrt(np.clip(to_xyz @ np.clip(linear, 0.0, 1.0), 0.0089, None) / [0.9505, 1.0, 1.089])
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


def gas_frame(*, is_there: int = 1, alarm: int = 0, reading: float = 0.0) -> GasFrame:
    """A leak at 6 m, 0.5 m left of the path, in a draught along it without meander."""
    env = make_config(gas={"plume": {"meander_mps": 0.0}})
    gas = records(GAS_RECORD, 1)
    leak, smell = gas["leak"], gas["smell"]
    leak["is_there"], leak["s_m"], leak["y_m"], leak["strength_ppm"] = is_there, 6.0, 0.5, 50.0
    leak["draught_mps"], leak["left_m"], leak["right_m"] = 0.3, 1.2, 1.2
    smell["alarm"], smell["reading"] = alarm, reading
    found = gas_frame_of(env, gas, 1)
    assert found is not None
    return found


def test_gas_clouds_the_floor_downwind_of_the_leak() -> None:
    frame = a_frame(records(PERSON, 0), gas=gas_frame(), ranges_m=np.empty(0))
    image = draw(frame)
    assert color_at(frame, image, 6.0, 0.5) == list(GAS)  # the mark
    clear, cloud = (np.array(color_at(frame, image, x, 0.5)) for x in (4.0, 7.0))
    assert clear.tolist() == list(FLOOR)
    share = (clear - cloud).sum() / (np.array(FLOOR) - GAS).sum()
    assert 0.3 < share < OPAQUE / 255  # of the color of gas, more than beside the plume
    assert color_at(frame, image, 7.0, -0.9) == list(FLOOR)


def test_a_leak_lies_beside_the_path_also_on_a_curve() -> None:
    place, gas = load_place("circle"), gas_frame().record
    x_m, y_m = leak_point(place, gas)
    beside_x, beside_y, heading_rad, _ = sample_path(place.path, np.array([6.0]))[0]
    offset = np.array([x_m - beside_x, y_m - beside_y])
    assert offset @ [np.cos(heading_rad), np.sin(heading_rad)] == pytest.approx(0.0, abs=1e-9)
    assert offset @ [-np.sin(heading_rad), np.cos(heading_rad)] == pytest.approx(0.5)


def test_without_a_leak_the_scene_is_that_without_gas() -> None:
    plain = a_frame(someone(5.0, 0.0))
    scene = draw(plain)[:-HEIGHT_PX]
    with_gas = draw(plain._replace(gas=gas_frame(is_there=0)))
    assert np.array_equal(with_gas[: len(scene)], scene)
    assert len(with_gas) == len(scene) + height_px(has_strip=True)


def test_an_alarm_is_told_by_color_and_by_a_word() -> None:
    def strip(**state: Any) -> Image:
        return draw(a_frame(someone(5.0, 0.0), gas=gas_frame(**state)))[-STRIP_PX:]

    quiet, sounding = strip(reading=1.5), strip(reading=1.5, alarm=1)
    bar, word = slice(20, 190), slice(340, 430)
    assert (quiet[:, word] == 255).all()
    assert (sounding[:, word] < 255).any()
    assert not np.array_equal(quiet[:, bar], sounding[:, bar])
    length = [(strip(reading=r)[:, bar] == GAS).all(-1).sum() for r in (0.0, 0.5, 1.0, 2.0, 9.0)]
    assert length[0] == 0
    assert length[0] < length[1] < length[2] < length[3] == length[4]


@pytest.mark.parametrize("vision", VISION)
def test_colour_blind_people_tell_the_patterns_apart(vision: str) -> None:
    linear = [(np.array(color) / 255.0) ** 2.2 for color in (*PEOPLE, NOBODY, GAS)]
    seen = [lab(np.array(VISION[vision]) @ color) for color in linear]

    nearest = min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2))

    assert nearest > 12.0  # 2.3 is just noticeable side by side


def test_a_mixed_color_lies_between() -> None:
    assert mixed((100, 0, 50), (0, 200, 50), 0.25) == (25, 150, 50)


def test_missing_pygame_names_the_install_command(monkeypatch: pytest.MonkeyPatch) -> None:
    real_import = builtins.__import__

    def without_pygame(name: str, *args: Any, **kwargs: Any) -> Any:
        if name == "pygame":
            raise ImportError(name)
        return real_import(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without_pygame)
    monkeypatch.delitem(sys.modules, canvas.__name__)

    with refused("pip install 'hazbot-gym[render]'", error=MissingExtra):
        importlib.import_module(canvas.__name__)
    assert canvas.__name__ not in sys.modules
