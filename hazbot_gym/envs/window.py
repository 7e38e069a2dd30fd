"""pygame window with a fixed frame rate; closing it is not an error."""

from __future__ import annotations

import os

from hazbot_gym.envs.canvas import FLOOR, INK, TEXT_PX, Image, pygame, regular_font
from hazbot_gym.errors import InvalidInput

NOTE_PX = 14  # of the note, from the corner
UNSEEN = ("dummy", "offscreen")  # SDL drivers without a display
_NO_DISPLAY = (
    "render_mode: given 'human', but there is no display; allowed is 'rgb_array', "
    "`hazbot watch --save FILE`, or SDL_VIDEODRIVER=dummy for an invisible window"
)


class Window:
    """The window of this process; pygame has one, a second ``Window`` would share it.

    Attributes:
        is_open: Whether the window is open.
        note: Text in the upper right corner.
    """

    def __init__(self, title: str, pictures_per_s: float) -> None:
        """Open the display.

        Args:
            title: Window title.
            pictures_per_s: Maximum frame rate; ``show`` waits for it.

        Raises:
            InvalidInput: there is no display.
        """
        _open_display()
        self.is_open, self.note = True, ""
        self._image: Image | None = None
        self._title, self._pictures_per_s = title, pictures_per_s
        self._clock = pygame.time.Clock()
        self._pressed: list[str] = []
        pygame.font.init()
        self._font, self._drawn = regular_font(TEXT_PX), ""

    def show(self, image: Image) -> None:
        """Show a picture (height, width, 3) of uint8, and wait for the frame period."""
        if not self.is_open:
            return
        height, width, _ = image.shape
        surface = pygame.display.get_surface()
        if surface is None or surface.get_size() != (width, height):
            surface = pygame.display.set_mode((width, height))
            pygame.display.set_caption(self._title)
        self._image = image
        self._draw()
        self.wait()

    def _draw(self) -> None:
        """Draw the picture, and the note over it."""
        surface, image = pygame.display.get_surface(), self._image
        if surface is None or image is None:
            return
        height, width, _ = image.shape
        surface.blit(pygame.image.frombuffer(image.tobytes(), (width, height), "RGB"), (0, 0))
        if self.note:
            text = self._font.render(self.note, True, INK, FLOOR)
            surface.blit(text, (width - text.get_width() - NOTE_PX, NOTE_PX))
        self._drawn = self.note
        pygame.display.flip()

    def wait(self) -> None:
        """Wait for one frame period, and process user events."""
        if self.note != self._drawn:
            self._draw()
        self._clock.tick(self._pictures_per_s)
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                self.close()
                return
            if event.type == pygame.KEYDOWN:
                self._pressed.append(pygame.key.name(event.key))

    def pressed(self) -> list[str]:
        """Return the names of the keys pressed since the last call, such as "space"."""
        pressed, self._pressed = self._pressed, []
        return pressed

    def close(self) -> None:
        """Close the window; idempotent."""
        if self.is_open:
            self.is_open = False
            pygame.display.quit()


def _open_display() -> None:
    """Initialize pygame's display; raise without a screen, unless a dummy driver is set."""
    try:
        pygame.display.init()
    except pygame.error as error:
        raise InvalidInput(_NO_DISPLAY) from error
    # Without a screen SDL fails silently.
    if pygame.display.get_driver() in UNSEEN and "SDL_VIDEODRIVER" not in os.environ:
        pygame.display.quit()
        raise InvalidInput(_NO_DISPLAY)
