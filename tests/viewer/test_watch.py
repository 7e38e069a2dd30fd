"""A policy is watched in a window or saved to a file, and measured as in ``hazbot eval``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
import PIL.Image
import pygame
import pytest

from hazbot_gym.envs.window import Window
from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.viewer import sinks
from hazbot_gym.viewer.sinks import PictureSink, Stopped, VideoSink, WindowSink
from hazbot_gym.viewer.watch import Show, save, table, watch_live
from tests.refusals import refused

CORRIDOR = "hazbot_gym/Corridor-v1"
# Two seconds that end with the time allowed.
SHORT = Show(
    "constant:0.5", CORRIDOR, overrides={"max_episode_steps": 20, "people": {"count": [1, 1]}}
)
BLACK = np.zeros((32, 48, 3), np.uint8)
FAST = 1000.0  # pictures a second


def black() -> Any:
    return BLACK


@pytest.fixture(autouse=True)
def closed_display() -> Iterator[None]:
    yield
    pygame.display.quit()


@pytest.fixture
def no_last_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a window close as soon as its last episode is over."""
    monkeypatch.setattr(sinks, "LAST_STAYS_S", 0.0)


def pixels(path: Path) -> Any:
    with PIL.Image.open(path) as picture:
        return np.asarray(picture)


def press(*keys: int) -> None:
    for key in keys:
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))


# --- on file -------------------------------------------------------------------------------------


def test_a_film_plays_as_long_as_the_episode_and_holds_its_end(tmp_path: Path) -> None:
    (row,) = save(SHORT, tmp_path / "video.mp4")

    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "video.mp4"))
    assert row["outcome"] == "timeout"
    assert frames == 3 * 20 + 45  # the last picture stays for 1.5 s
    assert seconds == pytest.approx(3.5, abs=0.05)
    assert [path.name for path in tmp_path.iterdir()] == ["video.mp4"]


def test_an_animation_moves(tmp_path: Path) -> None:
    save(SHORT._replace(speed=2.0), tmp_path / "video.gif")

    with PIL.Image.open(tmp_path / "video.gif") as video:
        assert video.format == "GIF"
        assert video.info["duration"] == 50
        assert video.n_frames >= 20
        first = np.asarray(video.convert("RGB"))
        video.seek(video.n_frames - 1)
        assert not np.array_equal(first, np.asarray(video.convert("RGB")))


def test_a_picture_is_of_the_end_or_of_a_given_time(tmp_path: Path) -> None:
    for name, at_s in (("end.png", None), ("also_end.png", 2.0), ("begin.png", 0.0)):
        save(SHORT, tmp_path / name, at_s=at_s)

    end, also_end, begin = (
        pixels(tmp_path / name) for name in ("end.png", "also_end.png", "begin.png")
    )
    assert end.shape == (544, 960, 3)
    assert np.array_equal(end, also_end)
    assert not np.array_equal(end, begin)


@pytest.mark.parametrize(
    ("name", "options", "complaint"),
    [
        ("video.avi", {}, "video.avi ... .mp4, .gif, .png"),
        ("there.png", {}, "there.png ... exists"),
        ("video.mp4", {"at_s": 1.0}, "at ... 1.0"),
        ("new.png", {"at_s": 9.0}, "at ... 9.0 ... 2.0 s"),
        ("there.png/below.png", {}, r"cannot write"),
    ],
)
def test_what_cannot_be_saved_is_refused_and_nothing_is_left(
    tmp_path: Path, name: str, options: dict[str, Any], complaint: str
) -> None:
    (tmp_path / "there.png").write_text("precious")

    with refused(complaint):
        save(SHORT, tmp_path / name, **options)

    assert [path.name for path in tmp_path.iterdir()] == ["there.png"]
    assert (tmp_path / "there.png").read_text() == "precious"


def test_a_picture_shows_one_episode(tmp_path: Path) -> None:
    with refused("episodes ... 2"):
        save(SHORT._replace(episodes=2), tmp_path / "new.png")


def test_a_file_is_replaced_if_asked(tmp_path: Path) -> None:
    (tmp_path / "there.png").write_text("old")

    save(SHORT, tmp_path / "there.png", is_replacing=True)

    with PIL.Image.open(tmp_path / "there.png") as picture:
        assert picture.format == "PNG"


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"episodes": 0}, "episodes ... 0"),
        ({"seed": -1}, "seed ... -1"),
        ({"speed": 0.0}, "speed ... 0.0"),
        ({"speed": float("nan")}, "speed ... nan"),
        ({"policy": "telepathy"}, "telepathy"),
        ({"env_id": "CartPole-v1"}, "CartPole-v1"),
    ],
    ids=str,
)
def test_bad_input_is_refused_and_nothing_is_left(
    tmp_path: Path, change: dict[str, Any], complaint: str
) -> None:
    with refused(complaint):
        save(SHORT._replace(**change), tmp_path / "video.gif")

    assert list(tmp_path.iterdir()) == []


def test_of_a_fast_film_pictures_are_left_out(tmp_path: Path) -> None:
    sink = VideoSink(tmp_path / "video", ".gif", 60.0)
    ramp = BLACK + 5 * np.arange(48, dtype=np.uint8)[:, np.newaxis]
    for k in range(7):
        sink.see(lambda k=k: np.roll(ramp, k, axis=1), k / 10, is_last=k == 6)
    sink.close()

    with PIL.Image.open(tmp_path / "video") as video:
        assert video.n_frames == 4


def test_pictures_between_decisions_do_not_stop_a_paused_window() -> None:
    sink = WindowSink("test", FAST)
    sink.see(black, 0.0, is_last=False)
    press(pygame.K_SPACE)
    sink.see(black, 0.1, is_last=False, is_between=True)  # would wait for ever


def test_a_window_tells_its_keys_and_that_it_is_paused(monkeypatch: pytest.MonkeyPatch) -> None:
    sink = WindowSink("test", FAST)
    picture = np.full((64, 640, 3), 200, np.uint8)
    shown = []

    def wait(window: Window, real: Callable[[Window], None] = Window.wait) -> None:
        real(window)
        shown.append(pygame.surfarray.array3d(pygame.display.get_surface()))
        if len(shown) == 3:
            press(pygame.K_SPACE)

    monkeypatch.setattr(Window, "wait", wait)
    press(pygame.K_SPACE)
    sink.see(lambda: picture, 0.0, is_last=False)
    assert len(np.unique(shown[0])) > 2  # keys, over the plain picture
    assert not np.array_equal(shown[0], shown[2])  # paused


def test_policy_and_place_are_named_in_the_picture(tmp_path: Path) -> None:
    for policy in ("constant:0.5", "constant:0.50"):
        save(SHORT._replace(policy=policy), tmp_path / f"{len(policy)}.png", at_s=0.0)
    one, other = (pixels(tmp_path / f"{count}.png") for count in (12, 13))
    rows, columns, _ = np.nonzero(one != other)
    assert rows.size
    assert rows.max() < 60  # the upper left corner, and nothing else
    assert columns.max() < 400


def test_a_picture_is_painted_once(tmp_path: Path) -> None:
    painted = []
    sink = PictureSink(tmp_path / "picture", 0.2)
    for k in range(5):
        sink.see(lambda k=k: painted.append(k) or BLACK, k / 10, is_last=k == 4)

    assert painted == [2]


# --- in a window ---------------------------------------------------------------------------------


@pytest.mark.usefixtures("no_last_stay")
def test_what_is_watched_is_what_eval_measures() -> None:
    show = SHORT._replace(episodes=2, seed=5, speed=100.0)

    rows = watch_live(show)

    measured = evaluate(
        show.policy, show.env_id, episodes=2, seed=5, overrides=show.overrides, engine="pymunk"
    )
    for row, expected in zip(rows, measured, strict=True):
        for name in ("seed", "outcome", "return", "delay_s", "personal_m"):
            assert row[name] == expected[name]
    assert not pygame.display.get_init()


@pytest.mark.parametrize(
    ("event", "is_for_good"),
    [
        (pygame.event.Event(pygame.KEYDOWN, key=pygame.K_q), True),
        (pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE), True),
        (pygame.event.Event(pygame.QUIT), True),
        (pygame.event.Event(pygame.KEYDOWN, key=pygame.K_r), False),
    ],
    ids=["q", "escape", "closed", "r"],
)
def test_the_user_ends_it(event: pygame.event.Event, is_for_good: bool) -> None:
    sink = WindowSink("test", FAST)
    sink.see(black, 0.0, is_last=False)
    pygame.event.post(event)

    with pytest.raises(Stopped) as stopped:
        sink.see(black, 0.1, is_last=False)
    assert stopped.value.for_good == is_for_good


def test_a_paused_window_waits_for_the_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    sink = WindowSink("test", FAST)
    sink.see(black, 0.0, is_last=False)
    presses = iter([[pygame.K_RIGHT], [], [pygame.K_SPACE]])
    waits = []

    def wait(window: Window, real: Callable[[Window], None] = Window.wait) -> None:
        press(*next(presses, []))
        waits.append(1)
        real(window)

    press(pygame.K_SPACE)
    monkeypatch.setattr(Window, "wait", wait)
    sink.see(black, 0.1, is_last=False)  # space pauses it, the right arrow lets one pass
    one = len(waits)
    sink.see(black, 0.2, is_last=False)  # space goes on
    two = len(waits)
    sink.see(black, 0.3, is_last=False)

    assert one < two
    assert len(waits) == two + 1
    assert next(presses, None) is None


def test_the_next_seed_follows_a_restart(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[float] = []

    def see(
        self: WindowSink, picture: Any, time_s: float, *, is_last: bool, is_between: bool = False
    ) -> None:
        if is_between:
            return
        seen.append(time_s)
        if len(seen) == 4:
            raise Stopped(for_good=False)

    monkeypatch.setattr(WindowSink, "see", see)
    seeds = [row["seed"] for row in evaluate("constant:0.5", CORRIDOR, episodes=2)]

    (row,) = watch_live(SHORT)

    assert row["seed"] == seeds[1]
    assert seen[:5] == [0.0, 0.1, 0.2, 0.3, 0.0]


@pytest.mark.usefixtures("no_last_stay")
def test_the_table_has_a_line_for_each_episode() -> None:
    rows = watch_live(SHORT._replace(episodes=2, speed=100.0))

    result = table(rows)

    assert [str(column.header) for column in result.columns] == [
        "seed",
        "outcome",
        "time_s",
        "return",
        "delay_s",
        "personal_m",
        "discomfort_s",
    ]
    assert result.row_count == 2
