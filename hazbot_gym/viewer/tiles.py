"""Drives of several policies in the same scenario, side by side in one picture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, SupportsFloat, cast

import gymnasium
import numpy as np

from hazbot_gym.envs.arguments import Environment, Info
from hazbot_gym.envs.corridor import CorridorEnv
from hazbot_gym.envs.frame import Frame, between
from hazbot_gym.envs.rendering import Painter
from hazbot_gym.policies.guard import Actions, Observations
from hazbot_gym.viewer.video import Image

COLUMNS_FROM = 3  # so many drives are shown in two columns
GAP_PX = 16  # between two scenes; a divisor that video codecs need


class FrameRecorder(gymnasium.Wrapper[Observations, Actions, Observations, Actions]):
    """Environment wrapper that keeps the frames of an episode.

    Attributes:
        frames: One for each instant.
    """

    def __init__(self, env: Environment) -> None:
        super().__init__(env)
        self.frames: list[Frame] = []

    def reset(self, **options: Any) -> tuple[Observations, Info]:
        """Reset, and keep the first frame."""
        answer = self.env.reset(**options)
        self.frames = [self._frame()]
        return answer

    def step(self, action: Actions) -> tuple[Observations, SupportsFloat, bool, bool, Info]:
        """Step, and keep the frame."""
        answer = self.env.step(action)
        self.frames.append(self._frame())
        return answer

    def _frame(self) -> Frame:
        return cast(CorridorEnv, self.env.unwrapped).viewer.frame


class Tiles:
    """Pictures of several drives; one that is over stays as it ended."""

    def __init__(self, drives: Mapping[str, list[Frame]]) -> None:
        """Prepare the pictures.

        Args:
            drives: Frames of each policy, by its name.
        """
        self._drives = drives
        self._painters = {name: Painter(frames[0].place) for name, frames in drives.items()}
        self.instants = max(map(len, drives.values()))

    def picture(self, instant: float) -> Image:
        """Return the picture of an instant, counted in decisions."""
        scenes = [
            self._painters[name].scene(_at(name, frames, instant))
            for name, frames in self._drives.items()
        ]
        columns = 2 if len(scenes) >= COLUMNS_FROM else 1
        blank = np.full_like(scenes[0], 255)
        scenes += [blank] * (-len(scenes) % columns)
        rows = [scenes[i : i + columns] for i in range(0, len(scenes), columns)]
        return _joined([_joined(row, axis=1) for row in rows], axis=0)


def _at(name: str, frames: list[Frame], instant: float) -> Frame:
    """Return the frame of an instant, with a caption of policy, time, speed and outcome."""
    k = min(int(instant), len(frames) - 1)
    frame = frames[k]
    if k + 1 < len(frames) and instant > k:
        frame = between(frame, frames[k + 1], instant - k)
    end = f"   {frame.outcome.replace('_', ' ')}" if frame.outcome else ""
    numbers = f"{frame.time_s:.1f} s   {abs(frame.speed_mps):.2f} m/s"
    return frame._replace(caption=f"{name}   {numbers}{end}")


def _joined(images: list[Image], axis: int) -> Image:
    """Return images beside each other, with gaps."""
    first = images[0]
    shape = (first.shape[0], GAP_PX) if axis == 1 else (GAP_PX, first.shape[1])
    gap = np.full((*shape, 3), 255, np.uint8)
    parts = [part for image in images for part in (gap, image)][1:]
    return np.concatenate(parts, axis=axis)
