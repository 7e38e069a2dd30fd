"""Where the real tracks are; they are not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def tracks_dir() -> Path:
    """Return the folder of real tracks: $HAZBOT_TRACKS, or shared/data beside the repository."""
    beside = Path(__file__).parents[3] / "shared" / "data"
    folder = Path(os.environ.get("HAZBOT_TRACKS") or beside)
    if not folder.is_dir():
        pytest.skip("real tracks are not here: set HAZBOT_TRACKS to their folder")
    return folder
