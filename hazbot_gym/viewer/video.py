"""Video and picture files: mp4, gif and png."""

from __future__ import annotations

import io
from collections.abc import Generator
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hazbot_gym.errors import MissingExtra

try:
    import imageio_ffmpeg
    import PIL.Image
except ImportError as error:
    raise MissingExtra("moviepy", "render") from error  # the extra with both packages

INCOMPLETE = "the video is not complete; is there enough space?"
Image = npt.NDArray[np.uint8]  # (height, width, 3), with even sides
PLAIN = PIL.Image.Dither.NONE  # dithering flickers and increases the size


class Video(Protocol):
    """A video file, written frame by frame."""

    def add(self, image: Image) -> None:
        """Add the next picture."""

    def close(self) -> None:
        """Finish the file."""

    def check(self) -> None:
        """Raise an OSError if the closed file is incomplete."""


class Mp4:
    """H.264 video, playable in every browser."""

    def __init__(self, path: Path, pictures_per_s: float) -> None:
        self._path, self._pictures_per_s = str(path), pictures_per_s
        self._writer: Generator[None, bytes | None, None] | None = None
        self._added = 0

    def add(self, image: Image) -> None:
        """Add the next picture."""
        if self._writer is None:
            height, width, _ = image.shape
            self._writer = imageio_ffmpeg.write_frames(
                self._path,
                (width, height),
                fps=self._pictures_per_s,
                quality=8,
                output_params=["-f", "mp4"],  # for any suffix
                ffmpeg_log_level="quiet",  # its message about a full disk is not for users
            )
            self._writer.send(None)
        try:
            self._writer.send(image.tobytes())
        except OSError as error:
            raise OSError(INCOMPLETE) from error
        self._added += 1

    def close(self) -> None:
        """Finish the file, if it has any frame."""
        if self._writer is not None:
            self._writer.close()

    def check(self) -> None:
        """Raise an OSError if frames are missing; ffmpeg does not report this itself."""
        try:
            found, _ = imageio_ffmpeg.count_frames_and_secs(self._path)
        except RuntimeError as error:
            raise OSError(INCOMPLETE) from error
        if found != self._added:
            raise OSError(INCOMPLETE)


class Gif:
    """An animation that starts over and over.

    Args:
        path: Of the file.
        pictures_per_s: Pictures a second.
        colors: Picture whose colors all pictures have; None for the first one's.
    """

    def __init__(self, path: Path, pictures_per_s: float, colors: Image | None = None) -> None:
        self._path, self._duration_ms = path, 1000.0 / pictures_per_s
        self._palette = None if colors is None else _palette_of(PIL.Image.fromarray(colors))
        self._packed: list[io.BytesIO] = []  # uncompressed frames would fill the memory

    def add(self, image: Image) -> None:
        """Add the next picture."""
        picture = PIL.Image.fromarray(image)
        self._palette = self._palette or _palette_of(picture)
        self._packed.append(io.BytesIO())
        picture.quantize(palette=self._palette, dither=PLAIN).save(self._packed[-1], "PNG")

    def close(self) -> None:
        """Write the file, if it has any frame."""
        pictures = (PIL.Image.open(packed) for packed in self._packed)
        if (first := next(pictures, None)) is not None:
            options = {"save_all": True, "duration": self._duration_ms, "loop": 0}
            content = io.BytesIO()  # PIL gives no reason for a file that it cannot write
            first.save(content, "GIF", append_images=pictures, **options)
            self._path.write_bytes(content.getvalue())

    def check(self) -> None:
        """Do nothing: ``close`` raises."""


def _palette_of(picture: PIL.Image.Image) -> PIL.Image.Image:
    return picture.quantize(method=PIL.Image.Quantize.FASTOCTREE, dither=PLAIN)


def save_picture(path: Path, image: Image) -> None:
    """Write a picture as png, for any suffix."""
    content = io.BytesIO()
    PIL.Image.fromarray(image).save(content, "PNG", optimize=True)
    path.write_bytes(content.getvalue())
