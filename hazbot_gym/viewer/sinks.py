"""Sinks of rendered frames: a window with key control, a video file, a single picture.

Keys in the window: space pauses and resumes, the right arrow steps one decision, r starts the next
episode, q or escape quits; with the policy ``keyboard``, the arrows up and down change the speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from hazbot_gym.errors import InvalidInput
from hazbot_gym.viewer.keyboard import Keyboard
from hazbot_gym.viewer.video import Gif, Image, Mp4, Video, save_picture

LAST_STAYS_S = 1.5  # display time of an episode's last frame
MOST_PER_S = 30.0  # frame rate of a video; frames are dropped above it
VIDEOS: dict[str, type[Mp4 | Gif]] = {".mp4": Mp4, ".gif": Gif}
PICTURE = ".png"
KEYS = "space: pause   right: step   r: next   q: quit"
PAUSED = "PAUSED   space: go on   right: step"


class Stopped(Exception):
    """The user stopped this episode or the whole session."""

    def __init__(self, *, for_good: bool) -> None:
        super().__init__()
        self.for_good = for_good


class Sink(Protocol):
    """Sink: receives every decision instant of an episode."""

    def see(
        self,
        picture: Callable[[], Image],
        time_s: float,
        *,
        is_last: bool,
        is_between: bool = False,
    ) -> None:
        """Receive one instant.

        Args:
            picture: Renders the instant.
            time_s: Episode time [s].
            is_last: Whether the episode ends here.
            is_between: Whether it lies between two decisions, where nothing stops.

        Raises:
            Stopped: The user stopped.
        """

    def close(self) -> None:
        """Close the sink."""


class WindowSink:
    """A window with key control."""

    def __init__(self, title: str, pictures_per_s: float, keyboard: Keyboard | None = None) -> None:
        from hazbot_gym.envs.window import Window

        self._window = Window(title, pictures_per_s)
        self._last_stays = round(LAST_STAYS_S * pictures_per_s)
        self._keyboard = keyboard
        self._keys = KEYS if keyboard is None else f"up, down: speed   {KEYS}"
        self._window.note = self._keys
        self._is_paused = False

    def see(
        self,
        picture: Callable[[], Image],
        time_s: float,
        *,
        is_last: bool,
        is_between: bool = False,
    ) -> None:
        """Show it, and return when the next decision is due."""
        self._window.show(picture())
        if is_between:
            return
        rest = self._last_stays if is_last else 0
        while not self._may_go_on() or rest > 0:
            self._window.wait()
            rest -= 1

    def close(self) -> None:
        """Close the window."""
        self._window.close()

    def _may_go_on(self) -> bool:
        """Handle the keys, and return True if the next decision may follow."""
        is_single_step = False
        for key in self._window.pressed():
            if key in ("q", "escape"):
                raise Stopped(for_good=True)
            if key == "r":
                raise Stopped(for_good=False)
            if key == "space":
                self._is_paused = not self._is_paused
            elif key == "right":
                self._is_paused = is_single_step = True
            elif self._keyboard is not None:
                self._keyboard.press(key)
        self._window.note = PAUSED if self._is_paused else self._keys
        if not self._window.is_open:
            raise Stopped(for_good=True)
        return is_single_step or not self._is_paused


class VideoSink:
    """A video of all instants."""

    def __init__(self, path: Path, ending: str, pictures_per_s: float) -> None:
        self._stride = math.ceil(pictures_per_s / MOST_PER_S)
        rate = pictures_per_s / self._stride
        self._video: Video = VIDEOS[ending](path, rate)
        self._last_stays = round(LAST_STAYS_S * rate)
        self._seen = 0

    def see(
        self,
        picture: Callable[[], Image],
        time_s: float,
        *,
        is_last: bool,
        is_between: bool = False,
    ) -> None:
        """Add the frame to the video."""
        if is_last or self._seen % self._stride == 0:
            image = picture()
            for _ in range(self._last_stays if is_last else 1):
                self._video.add(image)
        self._seen += 1

    def close(self) -> None:
        """Finish the video."""
        self._video.close()

    def check(self) -> None:
        """Raise an OSError if the video file is incomplete."""
        self._video.check()


class PictureSink:
    """One picture, of a given time or of the end."""

    def __init__(self, path: Path, at_s: float | None) -> None:
        self._path, self._at_s, self._is_done = path, at_s, False

    def see(
        self,
        picture: Callable[[], Image],
        time_s: float,
        *,
        is_last: bool,
        is_between: bool = False,
    ) -> None:
        """Write the picture at its time."""
        if is_between:
            return
        is_time = is_last if self._at_s is None else time_s >= self._at_s - 1e-6
        if is_time and not self._is_done:
            save_picture(self._path, picture())
            self._is_done = True
        if is_last and not self._is_done:
            raise InvalidInput(f"at: given {self._at_s}, the episode ended after {time_s} s")

    def close(self) -> None:
        """Do nothing: the picture is already written."""

    def check(self) -> None:
        """Do nothing: a picture that cannot be written raises at once."""
