"""For all tests: settings, where the real tracks are, and a browser that looks at pages."""

from __future__ import annotations

import fcntl
import itertools
import json
import os
import select
import shutil
import subprocess
import time
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


# --- the browser --------------------------------------------------------------------------------

NAMES = ("chromium", "chromium-browser", "google-chrome")
COMPLAINTS = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
PATIENCE_S = 120


class Browser:
    """A headless Chromium, spoken to in the DevTools protocol through pipes.

    Attributes:
        complaints: what the pages said to the console, and what went wrong in them.
    """

    def __init__(self, program: str, profile: Path) -> None:
        ours_out, theirs_in = _high_pipe()
        theirs_out, ours_in = _high_pipe()

        def connect() -> None:  # Chromium reads from 3 and writes to 4
            os.dup2(ours_out, 3)
            os.dup2(ours_in, 4)

        command = [
            program,
            *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"),
            *("--disable-background-networking", "--disable-component-update"),
            *("--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"),
        ]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, preexec_fn=connect, close_fds=False, **quiet)
        os.close(ours_out)
        os.close(ours_in)
        self._write, self._read = theirs_in, theirs_out
        self._ids, self._buffer, self._session = itertools.count(1), b"", ""
        self.complaints: list[str] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method of the protocol and return its result."""
        number = next(self._ids)
        message = {"id": number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        answer = self._wait_for(lambda heard: heard.get("id") == number)
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    def open(self, page: Path | str, width: int, height: int) -> None:
        """Open a page in a window of some size and wait until it is loaded."""
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            **{"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
        )
        self.ask("Page.navigate", url=page if isinstance(page, str) else page.as_uri())
        self._wait_for(lambda heard: heard.get("method") == "Page.loadEventFired")

    def run(self, script: str) -> Any:
        """Run the body of an asynchronous function on the page and return its value."""
        answer = self.ask(
            "Runtime.evaluate",
            expression=f"(async () => {{ {script} }})()",
            awaitPromise=True,
            returnByValue=True,
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def close(self) -> None:
        """End the browser."""
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)

    def _wait_for(self, is_it: Any) -> dict[str, Any]:
        deadline = time.monotonic() + PATIENCE_S
        while True:
            while b"\0" not in self._buffer:
                left = deadline - time.monotonic()
                assert select.select([self._read], [], [], max(left, 0.0))[0], "it went silent"
                heard = os.read(self._read, 1 << 16)
                assert heard, "the browser has ended"
                self._buffer += heard
            text, _, self._buffer = self._buffer.partition(b"\0")
            message: dict[str, Any] = json.loads(text)
            if message.get("method") in COMPLAINTS:
                self.complaints.append(json.dumps(message["params"]))
            if is_it(message):
                return message


def _high_pipe() -> tuple[int, int]:
    """Return a pipe whose ends are out of the way of 3 and 4."""
    low = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in low]
    for end in low:
        os.close(end)
    return high[0], high[1]


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium here: install Debian's chromium to test the page in a browser")
    browser = Browser(program, tmp_path / "profile")
    yield browser
    browser.close()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let tests among real people pass over tables of other kinds in the same folder."""
    other_kinds = "ignore:not read:hazbot_gym.errors.DoubtfulRecording"
    for item in items:
        if "tracks_dir" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.filterwarnings(other_kinds))
