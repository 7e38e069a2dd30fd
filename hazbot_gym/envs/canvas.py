"""Drawing surface, in metres of the place or in pixels of the picture.

It is drawn at twice the size and scaled down for antialiasing; no display is needed.
"""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hazbot_gym.core.state import Floats
from hazbot_gym.envs.frame import View
from hazbot_gym.errors import MissingExtra

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame as pygame  # for the window, too
    from PIL import ImageFont
except ImportError as error:
    raise MissingExtra("pygame-ce", "render") from error

Color = tuple[int, ...]  # red, green, blue, opacity, 0 to 255
Image = npt.NDArray[np.uint8]  # (height, width, 3)

SMOOTHING = 2  # supersampling factor
TEXT_PX = 19
FONT_SHARE = 0.72  # size of the font in the height of a line

# Pattern colours of Okabe and Ito (2008), purple darkened; a test measures their distance for
# colour-blind vision.
FLOOR: Color = (253, 253, 251)
OUTSIDE: Color = (229, 232, 236)
INK: Color = (55, 62, 73)
SOFT: Color = (158, 166, 176)
FAINT: Color = (232, 235, 238)
ROBOT: Color = (0, 114, 178)
ECHO: Color = (86, 180, 233)
SPACE: Color = (206, 96, 72)
PEOPLE: tuple[Color, ...] = ((230, 159, 0), (0, 158, 115), (170, 51, 119), (213, 94, 0))
NOBODY: Color = (144, 153, 162)  # a person without one of the four patterns
GAS: Color = (96, 80, 0)


class Canvas:
    """Reusable canvas of a view.

    Points are (n, 2) in metres; boxes and texts are placed in pixels from the upper left corner.
    """

    def __init__(self, view: View) -> None:
        pygame.font.init()
        self.view = view
        self._size = SMOOTHING * view.width, SMOOTHING * view.height
        self._surface = self._target = pygame.Surface(self._size)
        self._fonts: dict[int, pygame.font.Font] = {}

    # --- in metres -------------------------------------------------------------------------------

    def polygon(self, points: Floats, color: Color) -> None:
        """Fill a polygon."""
        pygame.draw.polygon(self._target, color, self._at(points).tolist())

    def ribbon(self, points: Floats, width_m: float, color: Color) -> None:
        """Draw a curve, or a straight piece, with round ends."""
        pixels = self._at(points)
        steps = np.hypot(*np.diff(pixels, axis=0).T)
        pixels = pixels[np.concatenate([[True], steps > 0.5])]
        half = max(width_m * self._scale, SMOOTHING) / 2.0
        if len(pixels) > 1:
            along = np.gradient(pixels, axis=0)
            along /= np.maximum(np.hypot(*along.T), 1e-9)[:, np.newaxis]
            across = half * along[:, ::-1] * np.array([-1.0, 1.0])
            outline = np.concatenate([pixels + across, (pixels - across)[::-1]])
            pygame.draw.polygon(self._target, color, outline.tolist())
        for end in (pixels[0], pixels[-1]):
            pygame.draw.circle(self._target, color, end.tolist(), half)

    def disc(self, x_m: float, y_m: float, radius_m: float, color: Color) -> None:
        """Fill a disc."""
        center = self._at(np.array([x_m, y_m])).tolist()
        pygame.draw.circle(self._target, color, center, radius_m * self._scale)

    def ring(self, x_m: float, y_m: float, radius_m: float, color: Color) -> None:
        """Draw the outline of a disc, one pixel wide."""
        center = self._at(np.array([x_m, y_m])).tolist()
        pygame.draw.circle(self._target, color, center, radius_m * self._scale, SMOOTHING)

    def mist(
        self, left_m: float, top_m: float, cell_m: float, opacity: npt.NDArray[np.uint8],
        color: Color,
    ) -> None:  # fmt: skip
        """Composite one color with the opacity (rows, columns) of square cells, smoothed."""
        rows, columns = opacity.shape
        pixels = np.empty((rows, columns, 4), np.uint8)
        pixels[..., :3], pixels[..., 3] = color, opacity
        cells = pygame.image.frombuffer(pixels.tobytes(), (columns, rows), "RGBA")
        cells = cells.convert(self._layer)  # the same format is composited 30 times faster
        side = cell_m * self._scale
        smooth = pygame.transform.smoothscale(cells, (round(side * columns), round(side * rows)))
        self._target.blit(smooth, self._at(np.array([left_m, top_m])).tolist())

    # --- in pixels -------------------------------------------------------------------------------

    def box(
        self, left: float, top: float, width: float, height: float, color: Color, *, radius: int = 0
    ) -> None:
        """Fill a box, with round corners if wanted."""
        area = [round(SMOOTHING * value) for value in (left, top, width, height)]
        pygame.draw.rect(self._target, color, area, border_radius=SMOOTHING * radius)

    def dot(
        self, x: float, y: float, radius: float, color: Color, *, is_ring: bool = False
    ) -> None:
        """Fill a disc, or draw its outline."""
        center, width = (SMOOTHING * x, SMOOTHING * y), SMOOTHING if is_ring else 0
        pygame.draw.circle(self._target, color, center, SMOOTHING * radius, width)

    def text(
        self, text: str, x: float, y: float, color: Color = INK, *, size: int = TEXT_PX,
        align: float = 0.0,
    ) -> float:  # fmt: skip
        """Write so that y is the middle of the line, and return the text's width.

        Args:
            text: One line.
            x: Left end, or right end with ``align=1``.
            y: Middle of the line.
            color: Text colour.
            size: Height of a line.
            align: Share of the width left of x.
        """
        ink = self._font(size).render(text, True, color)
        width, height = ink.get_size()
        self._target.blit(ink, (SMOOTHING * x - align * width, SMOOTHING * y - height / 2.0))
        return float(width / SMOOTHING)

    def width_of(self, text: str, *, size: int = TEXT_PX) -> float:
        """Return the width of a text."""
        return float(self._font(size).size(text)[0] / SMOOTHING)

    def _font(self, size: int) -> pygame.font.Font:
        if size not in self._fonts:
            self._fonts[size] = regular_font(SMOOTHING * size)
        return self._fonts[size]

    # --- the whole -------------------------------------------------------------------------------

    def fill(self, color: Color) -> None:
        """Fill the whole canvas."""
        self._target.fill(color)

    @contextmanager
    def layer(self) -> Iterator[None]:
        """Draw into a transparent layer without blending between shapes, then composite it."""
        self._layer.fill((0, 0, 0, 0))
        self._target = self._layer
        yield
        self._target = self._surface
        self._surface.blit(self._layer, (0, 0))

    def cover(self, other: Canvas) -> None:
        """Composite another canvas of the same size over this one."""
        self._surface.blit(other._surface, (0, 0))

    def cut_out(self, x_m: float, y_m: float) -> None:
        """Make the connected area of one colour around a point transparent (flood fill)."""
        column, row = (int(value) for value in self._at(np.array([x_m, y_m])))
        if not self._surface.get_rect().collidepoint(column, row):
            return
        color = self._surface.get_at((column, row))
        alike = pygame.mask.from_threshold(self._surface, color, (1, 1, 1, 255))
        reached = alike.connected_component((column, row))
        cut = pygame.Surface(self._size, pygame.SRCALPHA)
        cut.blit(self._surface, (0, 0))
        self._surface = self._target = reached.to_surface(
            cut, setcolor=(0, 0, 0, 0), unsetcolor=None
        )

    def image(self) -> Image:
        """Return the image at its final size."""
        small = pygame.transform.smoothscale(self._surface, (self.view.width, self.view.height))
        pixels = np.frombuffer(pygame.image.tobytes(small, "RGB"), np.uint8)
        return pixels.reshape(self.view.height, self.view.width, 3)

    @cached_property
    def _layer(self) -> pygame.Surface:
        return pygame.Surface(self._size, pygame.SRCALPHA)

    @property
    def _scale(self) -> float:
        return SMOOTHING * self.view.px_per_m

    def _at(self, points: Floats) -> Floats:
        return SMOOTHING * self.view.pixels(points)


def regular_font(line_px: int) -> pygame.font.Font:
    """Return Pillow's font, of regular weight; pygame's own is bold."""
    found = ImageFont.load_default(FONT_SHARE * line_px)
    if not isinstance(found, ImageFont.FreeTypeFont):  # a Pillow without FreeType
        return pygame.font.Font(None, line_px)
    return pygame.font.Font(io.BytesIO(found.font_bytes), round(FONT_SHARE * line_px))


def mixed(color: Color, other: Color, share: float) -> Color:
    """Return a mix of two colours."""
    return tuple(round(share * a + (1.0 - share) * b) for a, b in zip(color, other, strict=True))


def pale(color: Color) -> Color:
    """Return a lighter tone."""
    return mixed(color, (255, 255, 255), 0.4)


def dark(color: Color) -> Color:
    """Return a darker tone."""
    return mixed(color, (0, 0, 0), 0.6)


def turned(shape: Floats, x_m: float, y_m: float, heading_rad: float) -> Floats:
    """Rotate and translate a shape (n, 2) given at the origin, facing +x."""
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    stood: Floats = shape @ np.array([[cos, sin], [-sin, cos]]) + np.array([x_m, y_m])
    return stood
