"""Who looks on while a policy drives: a user at a window, a film, or somebody with a camera.

Keys in the window: space pauses and goes on, the right arrow goes on by one decision, r begins the
next episode, q or escape ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from hazbot_gym.errors import InvalidInput
from hazbot_gym.viewer.video import Film, Gif, Image, Mp4, save_picture

LAST_STAYS_S = 1.5  # how long the last picture of an episode stays
MOST_PER_S = 30.0  # pictures in a film; of a faster one some are left out
FILMS: dict[str, type[Mp4 | Gif]] = {".mp4": Mp4, ".gif": Gif}
PICTURE = ".png"


class Stopped(Exception):
    """The user wants to see no more of this episode, or no more at all."""

    def __init__(self, *, for_good: bool) -> None:
        super().__init__()
        self.for_good = for_good


class Screen(Protocol):
    """What sees every decision instant of an episode."""

    def see(self, picture: Callable[[], Image], time_s: float, *, is_last: bool) -> None:
        """See one instant.

        Args:
            picture: Paints it.
            time_s: In the episode.
            is_last: Whether the episode ends here.

        Raises:
            Stopped: Nobody wants to see what follows.
        """

    def close(self) -> None:
        """See nothing more."""


class LiveScreen:
    """A window, and the user's keys."""

    def __init__(self, title: str, pictures_per_s: float) -> None:
        from hazbot_gym.envs.window import Window

        self._window = Window(title, pictures_per_s)
        self._last_stays = round(LAST_STAYS_S * pictures_per_s)
        self._is_paused = False

    def see(self, picture: Callable[[], Image], time_s: float, *, is_last: bool) -> None:
        """Show it, and return when the user lets it go on."""
        self._window.show(picture())
        rest = self._last_stays if is_last else 0
        while not self._may_go_on() or rest > 0:
            self._window.wait()
            rest -= 1

    def close(self) -> None:
        """Close the window."""
        self._window.close()

    def _may_go_on(self) -> bool:
        """Do what the keys ask for, and return whether the next decision may follow."""
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
        if not self._window.is_open:
            raise Stopped(for_good=True)
        return is_single_step or not self._is_paused


class FilmScreen:
    """A film of all that is seen."""

    def __init__(self, path: Path, ending: str, pictures_per_s: float) -> None:
        self._stride = math.ceil(pictures_per_s / MOST_PER_S)
        rate = pictures_per_s / self._stride
        self._film: Film = FILMS[ending](path, rate)
        self._last_stays = round(LAST_STAYS_S * rate)
        self._seen = 0

    def see(self, picture: Callable[[], Image], time_s: float, *, is_last: bool) -> None:
        """Add it to the film."""
        if is_last or self._seen % self._stride == 0:
            image = picture()
            for _ in range(self._last_stays if is_last else 1):
                self._film.add(image)
        self._seen += 1

    def close(self) -> None:
        """Finish the film."""
        self._film.close()

    def check(self) -> None:
        """Raise an OSError if the file of the film is not whole."""
        self._film.check()


class PictureScreen:
    """One picture, of a given time or of the end."""

    def __init__(self, path: Path, at_s: float | None) -> None:
        self._path, self._at_s, self._is_done = path, at_s, False

    def see(self, picture: Callable[[], Image], time_s: float, *, is_last: bool) -> None:
        """Take the picture if it is time."""
        is_time = is_last if self._at_s is None else time_s >= self._at_s - 1e-6
        if is_time and not self._is_done:
            save_picture(self._path, picture())
            self._is_done = True
        if is_last and not self._is_done:
            raise InvalidInput(f"at: given {self._at_s}, the episode ended after {time_s} s")

    def close(self) -> None:
        """Do nothing: the picture is written."""

    def check(self) -> None:
        """Do nothing: a picture that cannot be written raises at once."""
