"""For all tests: settings, where the real tracks are, and a browser that looks at pages."""

from __future__ import annotations

import gc
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

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


class Browser:
    """A window of a headless Chromium.

    Attributes:
        page: Playwright's page.
        complaints: errors and console output of the pages.
    """

    def __init__(self, page: Any) -> None:
        self.page, self.complaints = page, list[str]()
        page.on("console", lambda message: self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def open(self, page: Path | str, width: int, height: int) -> None:
        """Open a page in a window of some size and wait until it is loaded."""
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.goto(page if isinstance(page, str) else page.as_uri())

    def run(self, script: str) -> Any:
        """Run the body of an asynchronous function on the page and return its value."""
        return self.page.evaluate(f"async () => {{ {script} }}")


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """Start the installed Chromium: nothing is downloaded."""
    playwright = pytest.importorskip("playwright.sync_api", reason="needs the extra dev")
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if program is None:
        pytest.skip("no Chromium here: install Debian's chromium to test pages in a browser")
    with playwright.sync_playwright() as driver:  # root has no sandbox
        yield driver.chromium.launch(executable_path=program, args=["--no-sandbox"])


@pytest.fixture
def browser(chromium: Any) -> Iterator[Browser]:
    """Open a window that shares nothing with those of other tests."""
    with chromium.new_context() as context:
        yield Browser(context.new_page())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let tests among real people pass over tables of other kinds in the same folder."""
    others = [f"ignore:not {what}:hazbot_gym.errors.DoubtfulRecording" for what in ("read", "used")]
    for item in items:
        if "tracks_dir" in getattr(item, "fixturenames", ()):
            for other in others:
                item.add_marker(pytest.mark.filterwarnings(other))


def pytest_collection_finish() -> None:
    """Spare the garbage collector what lives as long as the session: half a second each time."""
    gc.freeze()
