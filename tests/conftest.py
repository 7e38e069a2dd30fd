"""Settings for all tests, and where the real tracks are; they are not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import settings

# Windows open where nobody sees them; set before anything imports pygame.
os.environ["SDL_VIDEODRIVER"] = "dummy"

# The same examples every time, and however slow the machine: a red test is a red test.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")


@pytest.fixture(scope="session")
def tracks_dir() -> Path:
    """Return the folder of real tracks: $HAZBOT_TRACKS, or shared/data beside the repository."""
    beside = Path(__file__).parents[2] / "shared" / "data"
    folder = Path(os.environ.get("HAZBOT_TRACKS") or beside)
    if not folder.is_dir():
        pytest.skip("real tracks are not here: set HAZBOT_TRACKS to their folder")
    return folder
