"""Painter of frames: the scene with a panel of numbers below."""

from __future__ import annotations

import numpy as np

from hazbot_gym.core.state import Place
from hazbot_gym.envs.canvas import Canvas, Image
from hazbot_gym.envs.frame import PX_PER_M, Frame, View, size_of, view_of
from hazbot_gym.envs.panel import draw_panel, height_px
from hazbot_gym.envs.plume import PlumeGrid
from hazbot_gym.envs.scene import (
    draw_caption,
    draw_echoes,
    draw_floor,
    draw_leak,
    draw_people,
    draw_plume,
    draw_robot,
    draw_space,
    draw_trail,
    draw_walls,
    present,
)


class Painter:
    """Painter with a fixed picture size, set by the first place (required for videos)."""

    def __init__(self, place: Place, *, has_strip: bool = False) -> None:
        self.width, self.height = size_of(place)
        self._panel = Canvas(View(0.0, 0.0, 1.0, self.width, height_px(has_strip=has_strip)))
        self._view: View | None = None
        self._place: Place | None = None
        self._plume_grid: PlumeGrid | None = None

    def paint(self, frame: Frame) -> Image:
        """Return the picture of a frame as (height, width, 3) of uint8."""
        scene = self.scene(frame)
        draw_panel(self._panel, frame, self._scene.view.px_per_m)
        return np.concatenate([scene, self._panel.image()])

    def scene(self, frame: Frame) -> Image:
        """Return the picture without the panel of numbers."""
        self._prepare(frame)
        people, patterns = present(frame)
        scene = self._scene
        scene.cover(self._floor)
        has_leak = frame.gas is not None and frame.gas.record["leak"]["is_there"][0] == 1
        if has_leak:
            draw_plume(scene, frame, self._grid(frame))
        draw_space(scene, people)
        draw_trail(scene, frame)
        draw_echoes(scene, frame)
        scene.cover(self._walls)
        if has_leak:
            draw_leak(scene, frame)
        draw_people(scene, people, patterns)
        draw_robot(scene, frame)
        draw_caption(scene, frame)
        return scene.image()

    def _prepare(self, frame: Frame) -> None:
        """Redraw the static layer if it changed."""
        if frame.place is not self._place:
            self._place = frame.place
            self._whole = view_of(frame.place, self.width, self.height)
            self._view = self._plume_grid = None
        view = self._whole or View(frame.x_m, frame.y_m, PX_PER_M, self.width, self.height)
        if view != self._view:
            self._view = view
            self._scene, self._floor, self._walls = (Canvas(view) for _ in range(3))
            draw_floor(self._floor, frame.place)
            draw_walls(self._walls, frame)

    def _grid(self, frame: Frame) -> PlumeGrid:
        if self._plume_grid is None:
            assert frame.gas is not None
            leak = frame.gas.record["leak"][0]
            self._plume_grid = PlumeGrid(frame.place, leak["left_m"], leak["right_m"])
        return self._plume_grid


def draw(frame: Frame) -> Image:
    """Return the picture of a frame as (height, width, 3) of uint8."""
    return Painter(frame.place, has_strip=frame.has_strip).paint(frame)
