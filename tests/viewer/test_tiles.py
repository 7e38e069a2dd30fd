"""Policies side by side: their drives in the same scenarios, in one picture."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import numpy as np
import PIL.Image
import pygame
import pytest

from hazbot_gym.evaluation.rollout import evaluate
from hazbot_gym.viewer.keyboard import KEYBOARD, Keyboard
from hazbot_gym.viewer.sinks import WindowSink
from hazbot_gym.viewer.tiles import GAP_PX
from hazbot_gym.viewer.watch import Show, save, table
from tests.refusals import refused

SHORT = Show(
    "constant:0",
    "hazbot_gym/Corridor-v1",
    overrides={"max_episode_steps": 20, "people": {"count": [1, 1]}},
    beside=("constant:1",),
)
HEIGHT, WIDTH = 416, 960


def test_two_policies_are_one_above_the_other_and_measured_as_by_eval(tmp_path: Path) -> None:
    rows = save(SHORT, tmp_path / "both.png")

    with PIL.Image.open(tmp_path / "both.png") as picture:
        assert picture.size == (WIDTH, 2 * HEIGHT + GAP_PX)
        image = np.asarray(picture)
    upper, lower = image[60:HEIGHT], image[HEIGHT + GAP_PX + 60 :]  # below the captions
    assert not np.array_equal(upper, lower)
    for row, policy in zip(rows, SHORT.policies, strict=True):
        (expected,) = evaluate(policy, SHORT.env_id, episodes=1, overrides=SHORT.overrides)
        assert row["policy"] == policy
        assert row["return"] == expected["return"]
    assert str(table(rows).columns[0].header) == "policy"


def test_three_policies_are_in_two_columns(tmp_path: Path) -> None:
    save(SHORT._replace(beside=("constant:1", "constant:0.5")), tmp_path / "three.png", at_s=1.0)

    with PIL.Image.open(tmp_path / "three.png") as picture:
        assert picture.size == (2 * WIDTH + GAP_PX, 2 * HEIGHT + GAP_PX)


def test_a_film_of_two_has_thirty_pictures_a_second(tmp_path: Path) -> None:
    save(SHORT, tmp_path / "both.mp4")

    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "both.mp4"))
    assert frames == 3 * 20 + 45
    assert seconds == pytest.approx(3.5, abs=0.05)


@pytest.mark.parametrize(
    "beside", [("constant:0",), tuple(f"constant:0.{k}" for k in range(1, 5)), (KEYBOARD,)]
)
def test_too_many_the_same_and_the_keyboard_beside_others_are_refused(
    tmp_path: Path, beside: tuple[str, ...]
) -> None:
    with refused("policy: given"):
        save(SHORT._replace(beside=beside), tmp_path / "new.png")


def test_the_arrows_change_the_speed_and_a_new_episode_starts_at_rest() -> None:
    hand, seen = Keyboard(), np.zeros(12, np.float32)
    sink = WindowSink("test", 1000.0, hand)
    for key in (pygame.K_UP, pygame.K_UP, pygame.K_UP, pygame.K_DOWN):
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
    sink.see(lambda: np.zeros((32, 48, 3), np.uint8), 0.0, is_last=False)
    sink.close()

    assert hand.share == 0.2
    assert hand.predict(seen)[0].tolist() == pytest.approx([-0.6])
    assert hand.predict(seen, episode_start=np.array([True]))[0].tolist() == [-1.0]
    hand.press("down")
    assert hand.share == 0.0


def test_the_keyboard_needs_a_window(tmp_path: Path) -> None:
    with refused("save ... keyboard"):
        save(SHORT._replace(policy=KEYBOARD, beside=()), tmp_path / "new.mp4")
