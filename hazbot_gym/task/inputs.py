"""Input files of a config's scenarios."""

from __future__ import annotations

from pathlib import Path

from hazbot_gym.config import Config
from hazbot_gym.task.places import place_files
from hazbot_gym.task.recorded import tracks_files


def input_files(config: Config) -> list[Path]:
    """Return the input files of a config: the place's, or the recordings' and their JSONs.

    Raises:
        InvalidInput: A place or a recording is missing or cannot be used.
    """
    if config.people.model in ("replay", "seeded"):
        return tracks_files(config.tracks)
    return place_files(config.place)
