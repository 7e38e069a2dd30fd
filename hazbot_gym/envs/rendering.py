"""Painter of frames: the scene with a panel of numbers below."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import Place
from hazbot_gym.envs.canvas import Canvas, Image
from hazbot_gym.envs.frame import PX_PER_M, Frame, View, size_of, view_of
from hazbot_gym.envs.panel import HEIGHT_PX, draw_panel
from hazbot_gym.envs.scene import (
    draw_echoes,
    draw_floor,
    draw_people,
    draw_robot,
    draw_space,
    draw_trail,
    draw_walls,
    present,
)


class Painter:
    """Painter with a fixed picture size, set by the first place (required for videos)."""

    def __init__(self, place: Place) -> None:
        self.width, self.height = size_of(place)
        self._panel = Canvas(View(0.0, 0.0, 1.0, self.width, HEIGHT_PX))
        self._view: View | None = None
        self._place: Place | None = None

    def paint(self, frame: Frame) -> Image:
        """Return the picture of a frame as (height, width, 3) of uint8."""
        self._prepare(frame)
        people, patterns = present(frame)
        scene = self._scene
        scene.cover(self._floor)
        draw_space(scene, people)
        draw_trail(scene, frame)
        draw_echoes(scene, frame)
        scene.cover(self._walls)
        draw_people(scene, people, patterns)
        draw_robot(scene, frame)
        draw_panel(self._panel, frame, scene.view.px_per_m)
        return np.concatenate([scene.image(), self._panel.image()])

    def _prepare(self, frame: Frame) -> None:
        """Redraw the static layer if it changed."""
        if frame.place is not self._place:
            self._place = frame.place
            self._whole = view_of(frame.place, self.width, self.height)
            self._view = None
        view = self._whole or View(frame.x_m, frame.y_m, PX_PER_M, self.width, self.height)
        if view != self._view:
            self._view = view
            self._scene, self._floor, self._walls = (Canvas(view) for _ in range(3))
            draw_floor(self._floor, frame.place)
            draw_walls(self._walls, frame)


def draw(frame: Frame) -> Image:
    """Return the picture of a frame as (height, width, 3) of uint8."""
    return Painter(frame.place).paint(frame)
